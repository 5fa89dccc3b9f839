//! The drift after switching on, which dies away.

use fitter::terms::{Exponential, Operator};

use super::{
    Effect, Experiment, Facts, Handed, Range, Reading, reading, starts_over, time_constants, time_passes,
};
use crate::rows::Rows;
use crate::thresholds::effects::warmup_drift::LONGEST;

/// See the module's description.
pub struct WarmupDrift;

impl Effect for WarmupDrift {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "warmup_drift",
                title: "warm-up after switching on",
                formula: "A (1 − e^(−t/τ))",
                source: "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, chapter 5: the lumped-capacitance body after a step of heat",
                size: "either sign; 0.1 to some ten arcsec, a minute to an hour",
                confused_with: &["time_drift", "thermal_lag", "thermal_zero_drift"],
                variable: "t_s",
                of_one_time: true,
                told_by: &[
                    (Experiment::Levels, "time"),
                    (Experiment::Longer, "dies away"),
                    (Experiment::OneByOne, "time"),
                ],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        time_passes(rows)
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        starts_over(time_constants(rows, LONGEST), 9)
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        vec![time_constants(rows, LONGEST)]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        vec![rows.t_s.iter().map(|t| -(-t / shape[0]).exp_m1()).collect()]
    }

    fn operator(&self, _rows: &Rows, shape: &[f64]) -> Handed {
        Handed::plain(Operator::Exponential(Exponential::warm_up(shape[0])))
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        let unit = &rows.unit;
        vec![
            reading(format!("amplitude_{unit}"), amplitudes[0], unit.as_str()),
            reading("time_constant_s", shape[0], "s"),
        ]
    }
}
