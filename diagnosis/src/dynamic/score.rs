//! Free-run simulation of rows that were not fitted: the first rows of a run give its initial state.

use super::data::{ALL, Data};
use super::estimate::{PATIENCE, fit, positions};
use super::model::Model;
use super::recording::DynamicRecording;

/// Rows that give the initial state where the whole record is a periodic steady state.
const STEADY_ROWS: usize = 2000;

/// Simulates a recording with a given model, its initial states estimated from the rows that are not
/// scored; none where the simulation is unstable.
pub fn free_run(model: &Model, recording: &DynamicRecording) -> Option<Vec<f64>> {
    let mut fixed = model.clone();
    fixed.nominal_free = [false; 3];
    for term in &mut fixed.terms {
        term.free.iter_mut().for_each(|f| *f = false);
    }
    let head = head(recording);
    let start = Data::new(&head).after_history_of(recording);
    let states = fit(&fixed, &start.first_states(), &start, ALL, PATIENCE)?.states;
    positions(&fixed, &states, &Data::new(recording)).ok()
}

/// The recording with only the rows from which initial states are estimated.
fn head(recording: &DynamicRecording) -> DynamicRecording {
    let rows = if recording.unscored() == 0 { STEADY_ROWS } else { recording.unscored() };
    let keep: Vec<usize> = recording.runs.iter().flat_map(|r| r.start..r.end.min(r.start + rows)).collect();
    let pick = |column: &Vec<f64>| -> Vec<f64> { keep.iter().map(|k| column[*k]).collect() };
    let mut start = 0;
    let runs = recording
        .runs
        .iter()
        .map(|r| {
            let length = r.len().min(rows);
            start += length;
            start - length..start
        })
        .collect();
    DynamicRecording {
        t_s: pick(&recording.t_s),
        drives: recording.drives.iter().map(pick).collect(),
        positions: recording.positions.iter().map(pick).collect(),
        runs,
        period: None,
        amplitude: None,
        command: None,
        ..recording.clone()
    }
}

/// Root mean square of recorded less predicted over the scored rows that `wanted` selects.
pub fn rms(
    recording: &DynamicRecording,
    recorded: &[f64],
    predicted: &[f64],
    wanted: impl Fn(usize) -> bool,
) -> Option<f64> {
    let skip = recording.unscored();
    let rows = recording.runs.iter().flat_map(|r| r.start + skip..r.end).filter(|k| wanted(*k));
    let (mut sum, mut count) = (0.0, 0usize);
    for k in rows {
        sum += (recorded[k] - predicted[k]).powi(2);
        count += 1;
    }
    let rms = (sum / count as f64).sqrt();
    rms.is_finite().then_some(rms)
}
