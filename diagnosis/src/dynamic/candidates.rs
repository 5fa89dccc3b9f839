//! Effects that a recording may show beside its own model, too weak for its diagnosis to name them.

use super::data::Data;
use super::model::Model;
use super::recording::DynamicRecording;
use super::search::Search;
use crate::thresholds::compare::LEAST_PROMISE_IN_MOTION;
use crate::thresholds::dynamic::diagnose::SEARCH_STEPS;

/// What was looked for, and what was found.
pub struct Candidates {
    /// The model with one effect more, fitted: for each of the effects that promise most, the best first.
    pub models: Vec<Model>,
    /// Number of effects among which they were sought.
    pub sought: usize,
}

/// Seeks at most so many effects beside the model of a recording, leaving out those in `skip`.
pub fn candidates(recording: &DynamicRecording, model: &Model, skip: &[String], most: usize) -> Candidates {
    let data = Data::new(recording);
    let windows = data.windows(SEARCH_STEPS / model.substeps(data.step_s));
    let search = Search::new(&windows, skip, model.terms.len());
    let present = search.fit(model, &windows.first_states());
    let found = present
        .map_or_else(Vec::new, |present| search.contenders_promising(&[present], LEAST_PROMISE_IN_MOTION));
    // A drive that is straight between its samples and half a sample late is nearly a held one: beside a recording that is held,
    // that delay would seem to have come.
    let alike = found.into_iter().map(|fitted| fitted.model).filter(|found| found.hold == model.hold);
    let models = alike.take(most).collect();
    Candidates { models, sought: search.catalogue.len() }
}

/// The model of a recording with each of some effects in the place of its term `k`, as its last term, fitted.
pub fn in_place_of(recording: &DynamicRecording, model: &Model, k: usize, ids: &[String]) -> Vec<Model> {
    let data = Data::new(recording);
    let windows = data.windows(SEARCH_STEPS / model.substeps(data.step_s));
    let mut search = Search::new(&windows, &[], model.terms.len());
    search.catalogue.retain(|effect| ids.iter().any(|id| *id == effect.id));
    if search.catalogue.is_empty() {
        return Vec::new();
    }
    let fitted = |model: &Model| search.fit(model, &windows.first_states());
    let Some((present, without)) = fitted(model).zip(fitted(&model.without(k))) else { return Vec::new() };
    search.in_place_of(&present, k, &without).into_iter().map(|fitted| fitted.model).collect()
}
