//! A drift in proportion to time, whatever its cause.

use fitter::terms::{Operator, Product};

use super::{Effect, Experiment, Facts, Handed, Reading, reading, time_passes};
use crate::rows::Rows;

/// See the module's description.
pub struct TimeDrift;

impl Effect for TimeDrift {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "time_drift",
                title: "drift in proportion to time",
                formula: "ρ t, ρ in arcsec/h",
                source: "Riley, Handbook of Frequency Stability Analysis, NIST SP 1065 (2008): drift as the linear part of a record",
                size: "either sign; 0.1 to some ten arcsec/h",
                confused_with: &["warmup_drift", "thermal_zero_drift", "thermal_lag"],
                variable: "t_s",
                of_one_time: true,
                told_by: &[
                    (Experiment::Levels, "time"),
                    (Experiment::Longer, "goes on"),
                    (Experiment::OneByOne, "time"),
                ],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        time_passes(rows)
    }

    fn signature(&self, rows: &Rows, _shape: &[f64]) -> Vec<Vec<f64>> {
        vec![rows.t_s.iter().map(|t| t / 3600.0).collect()]
    }

    fn operator(&self, _rows: &Rows, _shape: &[f64]) -> Handed {
        Handed::scaled(Operator::Product(Product::of("t_s", 0.0)), 1.0 / 3600.0)
    }

    fn readings(&self, rows: &Rows, _shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let unit = &rows.unit;
        vec![reading(format!("rate_{unit}_per_h"), amplitudes[0], format!("{unit}/h"))]
    }
}
