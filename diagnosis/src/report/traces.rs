//! Simulated against recorded, where the simulation alone errs most; and what is left over all rows.

use super::draw::{Curve, Role, curves};
use crate::dynamic::DynamicRecording;
use crate::dynamic::diagnose::Predicted;
use crate::thresholds::report::traces::{CLOSE, ENVELOPE};

/// Titles and charts. Under feedback the drive is what is predicted.
pub fn charts(
    recording: &DynamicRecording,
    own: &Predicted,
    unit: &str,
    feedback: bool,
) -> Vec<(String, String)> {
    let columns = if feedback { &recording.drives } else { &recording.positions };
    let size = |k: usize| -> f64 {
        own.before[k].iter().zip(&columns[k]).map(|(a, b)| (a - b).powi(2)).filter(|e| e.is_finite()).sum()
    };
    let count = columns.len().min(own.before.len()).min(own.after.len());
    let Some(worst) = (0..count).max_by(|a, b| size(*a).total_cmp(&size(*b))) else { return Vec::new() };
    let (recorded, before, after) = (&columns[worst], &own.before[worst], &own.after[worst]);
    let rows = recorded.len().min(before.len()).min(after.len());
    let error = |row: usize| (recorded[row] - before[row]).powi(2);
    let block = |start: usize| -> f64 { (start..start + CLOSE).map(error).sum() };
    let starts = recording.runs.iter().flat_map(|run| {
        let first = run.start + recording.unscored();
        (first..run.end).step_by(CLOSE).filter(move |s| s + CLOSE <= run.end && s + CLOSE <= rows)
    });
    let Some(start) = starts.max_by(|a, b| block(*a).total_cmp(&block(*b))) else { return Vec::new() };
    let t = |row: usize| recording.t_s[row];
    let close = |role: Role, values: &[f64]| Curve {
        role,
        points: (start..start + CLOSE).map(|row| (t(row), values[row])).collect(),
    };
    let what = if feedback { "drive" } else { "position" };
    let name = if count > 1 { format!("{what} {}", worst + 1) } else { what.to_string() };
    let label = format!("{name} ({unit})");
    let near = curves(
        ("time (s)", &label),
        &[close(Role::Recorded, recorded), close(Role::Before, before), close(Role::After, after)],
    );
    // Rms of the residual block by block; rows, since time may start again with every run.
    let width = rows.div_ceil(ENVELOPE).max(1);
    let envelope = |role: Role, values: &[f64]| Curve {
        role,
        points: (0..rows)
            .step_by(width)
            .map(|from| {
                let to = (from + width).min(rows);
                let sum: f64 = (from..to).map(|row| (recorded[row] - values[row]).powi(2)).sum();
                (from as f64, (sum / (to - from) as f64).sqrt())
            })
            .collect(),
    };
    let left = curves(
        ("row", &format!("rms of the residual ({unit})")),
        &[envelope(Role::Before, before), envelope(Role::After, after)],
    );
    [
        (format!("Recorded and simulated {name}, where the simulation errs most"), near),
        (format!("What is left of {name} over the recording"), left),
    ]
    .into_iter()
    .filter_map(|(title, svg)| Some((title, svg?)))
    .collect()
}
