//! What is expected of a recording: the nominal plant, from the recording itself or from the user's own
//! simulation of it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::data::{ALL, Data, HOLDS};
use super::diagnose::OwnSimulation;
use super::estimate::{Fitted, fit, fit_with_each_hold};
use super::model::Term;
use super::noise::autoregression;
use super::recording::DynamicRecording;
use super::search::Search;
use super::start;
use crate::DiagnosisError;
use crate::thresholds::dynamic::expected::LOST;

/// The nominal plant with the effects `given`, identified from the recording, or from the user's simulation of it and then once
/// more beside the recording.
///
/// # Errors
/// [`DiagnosisError::NoPlant`] where no plant follows the drive, [`DiagnosisError::Rows`] where the simulation
/// has other rows.
pub fn nominal(
    recording: &DynamicRecording,
    data: &Data,
    simulated: Option<&OwnSimulation>,
    given: &[Term],
) -> Result<Fitted, DiagnosisError> {
    let best = match simulated {
        None if given.is_empty() => start::nominal(data).into_iter().next(),
        None => with(given, data),
        Some(own) => {
            own.of_rows(recording.rows())?;
            let theirs = stated(&own.positions, recording, data);
            theirs.and_then(|f| fit(&f.model, &data.first_states(), data, ALL))
        }
    };
    let best = best.ok_or_else(|| recording.lost(100.0))?;
    let part = best.part_left(data);
    if part > LOST { Err(recording.lost(100.0 * part)) } else { Ok(best) }
}

/// The plant with known effects, in the best way of running between the samples.
fn with(given: &[Term], data: &Data) -> Option<Fitted> {
    let plain = start::nominal(data).into_iter().next()?;
    let mut model = plain.model;
    model.terms.extend_from_slice(given);
    let fits = fit_with_each_hold(HOLDS, &model, &plain.states, data, ALL).into_iter();
    fits.min_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)))
}

/// The plant that a simulation states, with the effects of the catalogue that are in it: those the user knows.
/// Noise of the recording's size is put on it, so that no more is read out of it than the recording can show.
fn stated(simulated: &[f64], recording: &DynamicRecording, data: &Data) -> Option<Fitted> {
    let apart: Vec<f64> = data.position.iter().zip(simulated).map(|(a, b)| a - b).collect();
    let level = autoregression(&apart, &recording.runs).innovation;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    // Uniform numbers of unit variance.
    let noise = || 12f64.sqrt() * (random.random::<f64>() - 0.5);
    let positions = simulated.iter().zip(std::iter::repeat_with(noise)).map(|(x, e)| x + level * e);
    let copy = DynamicRecording { positions: vec![positions.collect()], ..recording.clone() };
    let theirs = Data::new(&copy);
    let rows = data.runs.iter().map(|r| r.len()).sum();
    let windows = theirs.windows(rows);
    let plain = start::nominal(&windows).into_iter().next()?;
    Some(Search::new(&windows, &[], 0).run(&plain))
}
