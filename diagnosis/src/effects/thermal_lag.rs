//! The zero follows a temperature that lags behind that of the base plate.

use fitter::terms::{Lag, Operator};

use super::{
    Effect, Experiment, Facts, Handed, Range, Reading, coefficient, low_pass, mean_of, present, reading,
    starts_over, time_constants,
};
use crate::rows::Rows;
use crate::thresholds::effects::thermal_lag::LONGEST;

/// See the module's description.
pub struct ThermalLag;

impl Effect for ThermalLag {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "thermal_lag",
                title: "zero drift with a temperature that lags",
                formula: "k (T_L − T̄), τ dT_L/dt = T − T_L, T_L = T at the first row",
                source: "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, chapter 5: the lumped-capacitance body",
                size: "either sign; 0.01 to some arcsec/K, a minute to an hour",
                confused_with: &["thermal_zero_drift", "time_drift", "warmup_drift"],
                variable: "temperature_c",
                told_by: &[
                    (Experiment::Levels, "temperature"),
                    (Experiment::Jump, "later"),
                    (Experiment::OneByOne, "temperature"),
                ],
                ..Facts::USUAL
            }
        }
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        present(&rows.temperature_c, "temperature_c").map(drop)
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        starts_over(time_constants(rows, LONGEST), 8)
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        vec![time_constants(rows, LONGEST)]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        let lagged = |t: &Vec<f64>| {
            let mean = crate::numerics::mean(t);
            low_pass(&rows.t_s, t, shape[0]).iter().map(|z| z - mean).collect()
        };
        rows.temperature_c.iter().map(lagged).collect()
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        Handed::plain(Operator::Lag(Lag::of("temperature_c", shape[0], mean_of(&rows.temperature_c))))
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        vec![coefficient(rows, amplitudes[0], "k", "K"), reading("time_constant_s", shape[0], "s")]
    }
}
