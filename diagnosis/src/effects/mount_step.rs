//! The mount, the reference or a probe slipped once: a step at one time.

use fitter::terms::{Operator, Step};

use super::{Effect, Handed, Place, Range, Reading, reading};
use crate::rows::Rows;

/// See the module's description.
pub struct MountStep;

impl Effect for MountStep {
    fn id(&self) -> &'static str {
        "mount_step"
    }

    fn title(&self) -> &'static str {
        "a step at one time (something slipped)"
    }

    fn formula(&self) -> &'static str {
        "h for t ≥ t₀"
    }

    fn source(&self) -> &'static str {
        "Page, Continuous inspection schemes, Biometrika 41 (1954) 100–115: the change point"
    }

    fn size(&self) -> &'static str {
        "either sign; 0.1 to some ten arcsec"
    }

    fn confused_with(&self) -> &'static [&'static str] {
        &["warmup_drift", "time_drift"]
    }

    fn place(&self, _rows: &Rows) -> Place {
        Place::on("t_s")
    }

    fn runtime_correctable(&self) -> bool {
        false
    }

    fn repeatable(&self) -> bool {
        true
    }

    fn begins_at_a_row(&self) -> bool {
        true
    }

    fn testable(&self, rows: &Rows) -> Result<(), String> {
        super::time_passes(rows)?;
        if rows.len() >= 8 { Ok(()) } else { Err("too few rows for a step".into()) }
    }

    fn starts(&self, rows: &Rows) -> Vec<Vec<f64>> {
        // The search tries every row; these stand for them where a few will do.
        let stride = rows.len().div_ceil(160).max(1);
        (2..rows.len().saturating_sub(1)).step_by(stride).map(|k| vec![k as f64]).collect()
    }

    fn ranges(&self, rows: &Rows) -> Vec<Range> {
        vec![Range { low: 2.0, high: rows.len() as f64 - 2.0, logarithmic: false, whole: true }]
    }

    fn signature(&self, rows: &Rows, shape: &[f64]) -> Vec<Vec<f64>> {
        vec![crate::jumps::step(rows.len(), shape[0] as usize)]
    }

    fn operator(&self, rows: &Rows, shape: &[f64]) -> Handed {
        let first = (shape[0] as usize).clamp(1, rows.len() - 1);
        Handed::plain(Operator::Step(Step::in_time(rows.t_s[first])))
    }

    fn readings(&self, rows: &Rows, shape: &[f64], amplitudes: &[f64]) -> Vec<Reading> {
        // The step fell between two rows: the later one is the first that has it.
        let first = (shape[0].round() as usize).clamp(1, rows.len() - 1);
        vec![
            reading(format!("step_{}", rows.unit), amplitudes[0], rows.unit.as_str()),
            reading("time_s", 0.5 * (rows.t_s[first - 1] + rows.t_s[first]), "s"),
        ]
    }
}
