//! The drift after switching on, which dies away.

use fitter::terms::{Exponential, Operator};

use super::{Effect, Handed, Place, Range, Reading, logarithmic, reading};
use crate::rows::Rows;

/// See the module's description.
pub struct WarmupDrift;

impl Effect for WarmupDrift {
    fn id(&self) -> &'static str {
        "warmup_drift"
    }

    fn title(&self) -> &'static str {
        "warm-up after switching on"
    }

    fn formula(&self) -> &'static str {
        "A (1 − e^(−t/τ))"
    }

    fn source(&self) -> &'static str {
        "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, chapter 5: the lumped-capacitance body after a step of heat"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["time_drift", "thermal_lag", "thermal_zero_drift"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("t_s")
    }

    fn runtime_correctable(&self) -> bool {
        false
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        super::time_apart(rows)?;
        if rows.t_s.last() > rows.t_s.first() { Ok(()) } else { Err("time stands still".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        let range = self.ranges(rows)[0];
        logarithmic(range.low, range.high, 9).into_iter().map(|tau| vec![tau]).collect()
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        // Faster than a few rows it is over before it is seen; slower than the recording it is a ramp.
        let rows_s = rows.duration_s() / rows.len().max(2) as f64;
        vec![Range { low: 3.0 * rows_s, high: 1.5 * rows.duration_s(), logarithmic: true, whole: false }]
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
