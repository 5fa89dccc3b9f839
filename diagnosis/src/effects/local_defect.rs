//! A flaw of a pad or of the mirror at one angle: a bump.

use fitter::terms::{Gaussian, Operator};

use super::{
    Effect, Experiment, Facts, Handed, Range, Reading, angle_observable, edge_unit, logarithmic, reading,
};
use crate::rows::Rows;
use crate::thresholds::effects::local_defect::{ALIKE, FEWEST_SEEN, NARROWEST, NARROWEST_START};

/// A width in steps of the angle within what can be told: narrower than a three-hundredth of the stroke it is one
/// reading of many.
fn in_steps(rows: &Rows, steps: f64) -> f64 {
    let (low, high) = rows.stroke();
    (steps * rows.step()).clamp((high - low) / 300.0, 0.5 * widest(rows))
}

/// Wider than an eighth of the stroke, it is a polynomial.
fn widest(rows: &Rows) -> f64 {
    let (low, high) = rows.stroke();
    (high - low) / 8.0
}

/// By what part of its height the centre of a bump moves in readings that hold the bump: (2/3)^(3/2).
const OF_OWN_HEIGHT: f64 = 0.544_331_053_951_817_4;

/// See the module's description.
pub struct LocalDefect;

impl Effect for LocalDefect {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "local_defect",
                title: "a local defect at one angle",
                formula: "H exp(−(θ − c)²/(2 w²))",
                source: "Fan et al., Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling and Correction, Sensors 19 (2019) 367, section 2: errors of the induction pads",
                size: "either sign; up to some ten arcsec, a half to a few steps of the angle wide",
                confused_with: &["periodic_error", "sensor_clipping"],
                variable: "angle_deg",
                repeatable: true,
                told_by: &[(Experiment::FinerSteps, "bump")],
                place_of_a_probe: Some(1),
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        // Seen once, it cannot be told from a disturbance at that moment.
        super::time_apart(rows)?;
        if rows.len() >= 24 { Ok(()) } else { Err("too few rows for a local defect".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        let (low, high) = rows.stroke();
        let mut starts = Vec::new();
        for width in logarithmic(in_steps(rows, NARROWEST_START) * 1.3, widest(rows) * 0.8, 3) {
            // What a polynomial leaves of a bump changes its sign within a width.
            let count = (((high - low) / (0.8 * width)).ceil() as usize).clamp(6, 48);
            for k in 0..=count {
                starts.push(vec![low + (high - low) * k as f64 / count as f64, width]);
            }
        }
        starts
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        let (low, high) = rows.stroke();
        vec![
            Range { low, high, logarithmic: false, whole: false },
            Range { low: in_steps(rows, NARROWEST), high: widest(rows), logarithmic: true, whole: false },
        ]
    }

    fn spacing(&self, k: usize, shape: &[f64]) -> Option<f64> {
        Some(if k == 0 { ALIKE[0] * shape[1] } else { ALIKE[1] })
    }

    fn possible_shape(&self, rows: &Rows, shape: &[f64]) -> bool {
        // Between places that were read anything may stand.
        rows.theta.iter().filter(|theta| (*theta - shape[0]).abs() < shape[1]).count() >= FEWEST_SEEN
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let bump = |theta: &f64| (-0.5 * ((theta - shape[0]) / shape[1]).powi(2)).exp();
        vec![rows.theta.iter().map(bump).collect()]
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        Handed::plain(Operator::Gaussian(Gaussian::of(angle_observable(rows), shape[0], shape[1])))
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let (suffix, per) = edge_unit(rows);
        // The angle is read with the bump in it, which moves the bump's own centre: the bump H g(y − H g(y)) is nearest to
        // H g(y − a H) where a = ∫ g g′² / ∫ g′².
        let undisturbed = shape[0] - OF_OWN_HEIGHT * amplitudes[0];
        vec![
            reading(format!("height_{}", rows.unit), amplitudes[0], rows.unit.as_str()),
            reading(format!("centre_{suffix}"), undisturbed / per, suffix),
            reading(format!("width_{suffix}"), shape[1] / per, suffix),
        ]
    }
}
