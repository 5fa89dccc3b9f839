//! Free-run simulation of rows that were not fitted: the first rows of a run give its initial state.

use super::data::{ALL, Data, SCORE};
use super::diagnose::Predicted;
use super::estimate::{fit, positions};
use super::model::Model;
use super::recording::DynamicRecording;
use crate::held_out::{Fit, Score};
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

/// What an answer's figures are of: a recording, another one that is held out, and the channel that is predicted.
pub struct Proof<'a> {
    pub recording: &'a DynamicRecording,
    pub held_out: Option<&'a DynamicRecording>,
    pub channel: fn(&DynamicRecording) -> &[f64],
    pub unit: &'a str,
}

impl Proof<'_> {
    /// The figures before and after. `own` and `other` are predictions of the two recordings; where nothing is held out,
    /// `without` are those of fits without the rows that score, which `fold` tells.
    pub fn fit(
        &self,
        own: &Predicted,
        other: Option<&Predicted>,
        without: [Option<Vec<f64>>; 2],
        fold: &[u8],
    ) -> Fit {
        let [before, after] = without;
        let figures = |own: &[Vec<f64>], other: Option<&[Vec<f64>]>, without: Option<Vec<f64>>| {
            let rms_of = |recording: &DynamicRecording, predicted: &[f64], wanted: &dyn Fn(usize) -> bool| {
                rms(recording, (self.channel)(recording), predicted, wanted)
            };
            if let Some((file, other)) = self.held_out.zip(other) {
                return Score {
                    train_rms: rms_of(self.recording, &own[0], &|_| true).unwrap_or(0.0),
                    held_out_rms: rms_of(file, &other[0], &|_| true),
                };
            }
            let predicted = without.as_ref().unwrap_or(&own[0]);
            Score {
                train_rms: rms_of(self.recording, predicted, &|k| fold[k] as usize != SCORE).unwrap_or(0.0),
                held_out_rms: rms_of(self.recording, predicted, &|k| fold[k] as usize == SCORE),
            }
        };
        let scores = [
            figures(&own.before, other.map(|o| &o.before[..]), before),
            figures(&own.after, other.map(|o| &o.after[..]), after),
        ];
        Fit::of(self.unit, self.held_out.map_or("block", |file| &file.file), scores)
    }
}
