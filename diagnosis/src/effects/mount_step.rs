//! The mount, the reference or a probe slipped once: a step at one time.

use fitter::terms::{Operator, Step};

use super::{Effect, Experiment, Facts, Handed, Range, Reading, reading};
use crate::rows::Rows;

/// See the module's description.
pub struct MountStep;

impl Effect for MountStep {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "mount_step",
                title: "a step at one time (something slipped)",
                formula: "h for t ≥ t₀",
                source: "Page, Continuous inspection schemes, Biometrika 41 (1954) 100–115: the change point",
                size: "either sign; 0.1 to some ten arcsec",
                confused_with: &["warmup_drift", "time_drift"],
                variable: "t_s",
                of_one_time: true,
                begins_at_a_row: true,
                repeatable: true,
                told_by: &[
                    (Experiment::Levels, "time"),
                    (Experiment::Longer, "stays"),
                    (Experiment::OneByOne, "time"),
                ],
                ..Facts::USUAL
            }
        }
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
