//! A probe runs out of its range on one side: from there on its slope is another.

use fitter::terms::{Hinge, Operator, Side};

use super::{Effect, Experiment, Facts, Handed, Range, Reading, angle_observable, edge_unit, reading};
use crate::rows::Rows;
use crate::thresholds::effects::sensor_clipping::INNERMOST;

/// See the module's description.
pub struct SensorClipping;

impl Effect for SensorClipping {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "sensor_clipping",
                title: "a probe at the end of its range",
                formula: "b·max(0, θ − θ_c), or b·min(0, θ − θ_c) on the negative side",
                source: "Fan et al., Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling and Correction, Sensors 19 (2019) 367, section 2.1: probes of 0.5 mm range",
                size: "either sign: of a loss of sensitivity negative; up to some per cent of the slope",
                confused_with: &["local_defect", "periodic_error"],
                variable: "angle_deg",
                told_by: &[(Experiment::FinerSteps, "slope")],
                place_of_a_probe: Some(0),
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        // Seen once, it cannot be told from a disturbance at that moment.
        super::time_apart(rows)?;
        if rows.whole_turn().is_some() {
            return Err("a sensor that turns has no end of its range".into());
        }
        if rows.len() >= 24 { Ok(()) } else { Err("too few rows for a change of slope".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        let (low, high) = rows.stroke();
        let half = 0.5 * (high - low);
        let first = (1.3 * rows.step() / half).clamp(0.02, 0.3);
        // Beside a polynomial of order 9 the merit has several maxima over the threshold: a start for every
        // step of the angle, or for every fortieth of the stroke.
        let most = 1.0 - INNERMOST;
        let count = ((most - first) * half / rows.step()).clamp(6.0, 20.0) as usize;
        (0..=count)
            .map(|k| first + (most - first) * k as f64 / count as f64)
            .flat_map(|part| [vec![high - part * half, 1.0], vec![low + part * half, -1.0]])
            .collect()
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        let (low, high) = rows.stroke();
        let margin = 1.05 * rows.step().min(0.1 * (high - low));
        vec![
            Range { low: low + margin, high: high - margin, logarithmic: false, whole: false },
            Range { low: 1.0, high: 1.0, logarithmic: false, whole: true },
        ]
    }

    fn possible_shape(&self, rows: &Rows, shape: &[f64]) -> bool {
        let (low, high) = rows.stroke();
        let from_middle = shape[1] * (shape[0] - 0.5 * (low + high));
        from_middle >= 0.999 * INNERMOST * 0.5 * (high - low)
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let beyond = |theta: &f64| shape[1] * (shape[1] * (theta - shape[0])).max(0.0);
        vec![rows.theta.iter().map(beyond).collect()]
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        let side = if shape[1] > 0.0 { Side::Above } else { Side::Below };
        Handed::scaled(Operator::Hinge(Hinge::of(angle_observable(rows), shape[0], side)), shape[1])
    }

    fn readings(&self, rows: &Rows, shape: &[f64], _amplitudes: &[f64]) -> Vec<Reading> {
        let (suffix, per) = edge_unit(rows);
        vec![reading(format!("threshold_{suffix}"), shape[0] / per, suffix)]
    }
}
