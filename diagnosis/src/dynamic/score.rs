//! Free-run simulation of rows that were not fitted: the first rows of a run give its initial state.

use super::data::{ALL, Data};
use super::estimate::{fit, positions};
use super::model::Model;
use super::recording::DynamicRecording;
use crate::thresholds::dynamic::estimate::PATIENCE;
use crate::thresholds::dynamic::score::STEADY_ROWS;

/// Simulates a recording with a given model, its initial states estimated from the rows that are not
/// scored; none where the simulation is unstable.
pub fn free_run(model: &Model, recording: &DynamicRecording) -> Option<Vec<f64>> {
    let mut fixed = model.clone();
    fixed.nominal_free = [false; 3];
    for term in &mut fixed.terms {
        term.free.iter_mut().for_each(|f| *f = false);
    }
    let rows = if recording.unscored() == 0 { STEADY_ROWS } else { recording.unscored() };
    let start = Data::new(recording).head(rows);
    let states = fit(&fixed, &start.first_states(), &start, ALL, PATIENCE)?.states;
    positions(&fixed, &states, &Data::new(recording)).ok()
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
