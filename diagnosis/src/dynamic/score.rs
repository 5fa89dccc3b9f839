//! Free-run simulation of rows that were not fitted: the first rows of a run give its initial state.

use fitter::table::Values;

use super::data::{ALL, Data, SCORE};
use super::diagnose::{Case, Predicted};
use super::estimate::{self, Simulated};
use super::model::Model;
use super::recording::DynamicRecording;
use crate::held_out::{Fit, Score};
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
    let states = estimate::fit(&fixed, &start.first_states(), &start, ALL)?.states;
    fixed.positions(&states, &Data::new(recording)).ok()
}

/// Root mean square of recorded less predicted channels on some rows; none where it is no number.
pub fn rms(
    recorded: &[Values],
    predicted: &[Vec<f64>],
    rows: impl Iterator<Item = usize> + Clone,
) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for (recorded, predicted) in recorded.iter().zip(predicted) {
        for k in rows.clone() {
            sum += (recorded[k] - predicted[k]).powi(2);
            count += 1;
        }
    }
    let rms = (sum / count as f64).sqrt();
    rms.is_finite().then_some(rms)
}

/// The channels of a recording that are predicted.
pub type Channels = fn(&DynamicRecording) -> &[Values];

/// The figures before and after, of some channels in their unit. `own` and `other` are predictions of the recording and
/// of the one that is held out; where none is, `without` are those of fits without the rows that score, which `fold` tells.
pub fn fit(
    case: &Case,
    (channels, unit): (Channels, &str),
    own: &Predicted,
    other: Option<&Predicted>,
    without: [Option<Vec<f64>>; 2],
    fold: &[u8],
) -> Fit {
    let [before, after] = without.map(|column| column.map(|column| vec![column]));
    let figures = |own: &[Vec<f64>], other: Option<&[Vec<f64>]>, without: Option<Vec<Vec<f64>>>| {
        let rms_of =
            |recording: &DynamicRecording, predicted: &[Vec<f64>], wanted: &dyn Fn(&usize) -> bool| {
                rms(channels(recording), predicted, recording.scored_rows().filter(wanted))
            };
        if let Some((file, other)) = case.held_out.zip(other) {
            return Score {
                train_rms: rms_of(case.recording, own, &|_| true).unwrap_or(0.0),
                held_out_rms: rms_of(file, other, &|_| true),
            };
        }
        let predicted = without.as_deref().unwrap_or(own);
        let scores = |k: &usize| fold[*k] as usize == SCORE;
        Score {
            train_rms: rms_of(case.recording, predicted, &|k| !scores(k)).unwrap_or(0.0),
            held_out_rms: rms_of(case.recording, predicted, &scores),
        }
    };
    let scores = [
        figures(&own.before, other.map(|o| &o.before[..]), before),
        figures(&own.after, other.map(|o| &o.after[..]), after),
    ];
    Fit::of(unit, case.held_out.map_or("block", |file| &file.file), scores)
}
