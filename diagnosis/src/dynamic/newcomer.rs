//! Effects that a recording may show beside its own model, though its diagnosis names none of them: too weak for it alone.

use super::data::Data;
use super::model::Model;
use super::recording::DynamicRecording;
use super::search::Search;
use crate::thresholds::dynamic::diagnose::SEARCH_STEPS;

/// What was looked for, and what was found.
pub struct Newcomers {
    /// The model with one of the effects more that promise most, fitted; the best first.
    pub models: Vec<Model>,
    /// Number of effects among which they were sought.
    pub sought: usize,
}

/// Seeks effects beside the model of a recording, but those that are to be skipped.
pub fn newcomers(recording: &DynamicRecording, model: &Model, skip: &[String], most: usize) -> Newcomers {
    let data = Data::new(recording);
    let windows = data.windows(SEARCH_STEPS / model.substeps(data.step_s));
    let search = Search::new(&windows, skip, model.terms.len());
    let present = search.fit(model, &windows.first_states());
    let found = present.map_or_else(Vec::new, |present| search.contenders(&[present]));
    let models = found.into_iter().take(most).map(|fitted| fitted.model).collect();
    Newcomers { models, sought: search.catalogue.len() }
}
