//! One recording beside a plant in equations, from rows to everything that is said of it.

use std::sync::Arc;

use motion::equations::{MotionEffect, Plant};
use numerics::{Symmetric, parallel};

use super::super::accurate::estimated;
use super::super::data::{ALL, Data, UNSCORED};
use super::super::diagnose::{Case, DynamicOutcome, Identified, Predicted, repeated};
use super::super::estimate::{Fitted, Simulated, fit};
use super::super::joint::equations::InEquations;
use super::super::judge::{self, Problem, Withdrawn};
use super::super::noise::autoregression;
use super::super::recording::DynamicRecording;
use super::super::verdict::{covariance, listed, next_experiment, reach, unidentifiable};
use super::super::{remainder, score};
use super::model::Model;
use super::search::Search;
use super::{catalogue, forms, start, verdict};
use crate::DiagnosisError;
use crate::diagnosis::{Diagnosis, NoiseFloor};
use crate::thresholds::dynamic::expected::LOST;
use crate::thresholds::dynamic::score::STEADY_ROWS;
use crate::verdict::{CATALOGUED, DECLARED, EMPIRICAL, Said, Verdict};

/// A recording, and what was found in it.
struct Found<'a> {
    case: &'a Case<'a>,
    data: &'a Data<'a>,
    search: &'a Search<'a>,
    /// Ids of the effects of the catalogue.
    catalogued: Vec<String>,
    before: Fitted<Model>,
    /// The model with effects, on the windows of the search and on the whole recording.
    chosen: Fitted<Model>,
    found: Fitted<Model>,
}

/// Diagnoses one recording beside a plant in equations; where named effects leave structure, with forms without a name.
///
/// # Errors
/// One of [`DiagnosisError`]: the recording or the plant cannot be used at all.
pub fn diagnose(case: &Case) -> Result<DynamicOutcome, DiagnosisError> {
    match attempt(case, false)? {
        Some(first) => Ok(forms::described(case, first)),
        None => unreachable!("no forms are sought"),
    }
}

/// One search, with or without forms, and its answer; none where forms are sought and none is found.
///
/// # Errors
/// As [`diagnose`].
pub fn attempt(case: &Case, with_forms: bool) -> Result<Option<DynamicOutcome>, DiagnosisError> {
    let (recording, options) = (case.recording, case.options);
    let plant = Plant::of(case.plant_file, case.plant).ok_or_else(|| no_equations(recording, 100.0))??;
    let (as_read, drives) = (recording, recording.drives.len());
    let recording = &recording.with_inputs(&plant.inputs);
    let held_out = case.held_out.map(|other| other.with_inputs(&plant.inputs));
    let case = &Case { recording, held_out: held_out.as_ref(), ..*case };
    let (wanted, found) = (plant.inputs.len(), recording.drives.len());
    if recording.positions.len() != 1 || (wanted != found && wanted > 0) {
        let positions = recording.positions.len();
        return Err(DiagnosisError::Inputs { file: recording.file.clone(), wanted, found, positions });
    }
    if case.simulated.is_some() {
        return Err(DiagnosisError::OwnSimulation { file: recording.file.clone() });
    }
    let plant = Arc::new(plant);
    let data = Data::new(recording);
    let lost = || no_equations(recording, 100.0);
    let nominal = start::nominal(&plant, &data)?.ok_or_else(lost)?;
    let (windows, seen) = (&nominal.windows, &nominal.free);
    let left = seen.part_left(windows);
    if left > LOST {
        return Err(no_equations(recording, 100.0 * left));
    }
    let skip = |id: &str| options.skip.iter().any(|skip| skip == id);
    let mut effects: Vec<_> = options.own.iter().filter(|effect| !skip(&effect.text.id)).cloned().collect();
    let of_catalogue = catalogue::effects(&plant, drives);
    let catalogued = verdict::ids(&of_catalogue);
    effects.extend(of_catalogue.into_iter().filter(|effect| !skip(&effect.text.id)));
    if with_forms {
        effects.extend(catalogue::forms(&plant, as_read));
    }
    effects.iter_mut().for_each(|effect| *effect = Arc::new(catalogue::scaled(effect, &data)));
    let search = Search { data: windows, catalogue: effects, given: seen.model.terms.len() };
    let chosen = search.run(&nominal).unwrap_or_else(|| seen.clone());
    let is_form = |id: &str| kind(&options.own, &catalogued, id) == EMPIRICAL;
    if with_forms && !chosen.model.terms.iter().any(|term| is_form(&term.effect.text.id)) {
        return Ok(None);
    }
    let (before, found) =
        parallel::join(|| all_rows(&data, windows, seen), || all_rows(&data, windows, &chosen));
    let (before, found) = (before.ok_or_else(lost)?, found.ok_or_else(lost)?);
    let found = Found { case, data: &data, search: &search, catalogued, before, chosen, found };
    judge::standing(&found).map(Some)
}

/// That the equations follow a recording with no parameters: the best leave so much of the position's variance.
fn no_equations(recording: &DynamicRecording, percent: f64) -> DiagnosisError {
    DiagnosisError::NoEquations { file: recording.file.clone(), percent }
}

/// A model on the whole recording, its initial states as the file has them; it was seen in some windows.
fn all_rows(data: &Data, windows: &Data, seen: &Fitted<Model>) -> Option<Fitted<Model>> {
    let model = &seen.model;
    let free_starts: Vec<bool> = model.plant.starts.iter().map(Option::is_none).collect();
    let first: Vec<Vec<f64>> = data
        .runs
        .iter()
        .map(|run| {
            let window = windows.runs.iter().position(|window| window.start == run.start);
            let fitted = window.and_then(|number| seen.states.get(number)).into_iter().flatten();
            fitted.zip(&model.plant.starts).map(|(value, given)| given.unwrap_or(*value)).collect()
        })
        .collect();
    let model = Model { free_starts, ..model.clone() };
    estimated(&model, &first, data, ALL)
}

impl Problem for Found<'_> {
    fn case(&self) -> &Case<'_> {
        self.case
    }

    fn answer(&self, withdrawn: &Withdrawn) -> Result<DynamicOutcome, DiagnosisError> {
        let Some(model) = verdict::without(&self.chosen.model, &withdrawn.effects) else {
            return Ok(self.said(&self.chosen, &self.found));
        };
        let lost = || no_equations(self.case.recording, 100.0);
        let small = self.search.fit(&model, &self.chosen.states).ok_or_else(lost)?;
        let found = all_rows(self.data, self.search.data, &small).ok_or_else(lost)?;
        Ok(self.said(&small, &found))
    }
}

impl Found<'_> {
    /// Everything that is said of a model: `small` on the windows of the search, `found` on the whole recording.
    fn said(&self, small: &Fitted<Model>, found: &Fitted<Model>) -> DynamicOutcome {
        let (data, search, before) = (self.data, self.search, &self.before);
        let nominal = self.case.plant;
        // The proof: the nominal and the chosen model, fitted and chosen without the rows that score.
        let proof_of = |f: &Fitted<Model>| fit(&f.model, &f.states, data, UNSCORED);
        let proofs = || parallel::join(|| proof_of(before), || proof_of(found));
        let rest = || parallel::join(|| self.floor(found), || self.covariance(found));
        let ((proof_before, proof_after), ((above, floor), covariance)) = parallel::join(proofs, rest);
        let named_any = found.model.terms.len() > search.given;
        let verdict = match (named_any, above > 0.0) {
            (false, false) => Verdict::Consistent,
            (false, true) => Verdict::Unexplained,
            (true, false) => Verdict::Explained,
            (true, true) => Verdict::PartlyExplained,
        };
        let named = match named_any {
            true => verdict::effects(search, data, [small, found], &covariance, |id| self.kind(id)),
            false => Vec::new(),
        };
        let explained = (1.0 - found.cost(ALL) / before.cost(ALL).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let locations =
            verdict::locations(found, &self.case.recording.further, &named, explained, |variable| {
                reach(data, &self.case.recording.t_s, variable)
            });
        let own = Predicted::by(self.case.recording, [before, found], |f| {
            vec![f.positions(data).unwrap_or_default()]
        });
        let fits = [before, found];
        let other = self.case.held_out.map(|r| Predicted::by(r, fits, |fitted| held_out(r, fitted)));
        let idle = proof_after.as_ref().filter(|_| named_any).and_then(|f| search.idle(f, data));
        let predicted = |f: &Option<Fitted<Model>>| f.as_ref().and_then(|f| f.positions(data).ok());
        let without: [_; 2] = parallel::join(|| predicted(&proof_before), || predicted(&proof_after)).into();
        let channels: score::Channels = |recording| &recording.positions;
        let channels = (channels, nominal.plant.position_unit.as_str());
        let fit = score::fit(self.case, channels, &own, other.as_ref(), without, &data.fold);
        let said = Said {
            verdict,
            unidentifiable: unidentifiable(&named),
            next_experiment: next_experiment(verdict, &named, &locations, &|id| self.experiment(id)),
            locations,
            effects: listed(named),
        };
        let of_plant = verdict::plant(found, &covariance);
        let diagnosis = Diagnosis { plant: of_plant, ..self.case.said(said, floor, fit) };
        let plant = verdict::to_file(found, nominal);
        let identified = InEquations { fitted: found.clone(), names: Vec::new() };
        let identified = Identified::Equations(Box::new(identified));
        DynamicOutcome { diagnosis, plant, own, other, idle, identified }
    }

    /// Where an effect comes from.
    fn kind(&self, id: &str) -> &'static str {
        kind(&self.case.options.own, &self.catalogued, id)
    }

    /// What tells an effect from others.
    fn experiment(&self, id: &str) -> String {
        let effect = self.search.catalogue.iter().find(|effect| effect.text.id == id);
        effect.map_or_else(String::new, |effect| effect.text.experiment.clone())
    }

    /// What is above the noise, as squared residuals, and the noise.
    fn floor(&self, found: &Fitted<Model>) -> (f64, NoiseFloor) {
        let rest = found.residual(self.data).unwrap_or_default();
        let noise = autoregression(&rest, &self.data.runs);
        let repeated = repeated(self.case.recording);
        let above = remainder::above(found, repeated, &noise, found.model.terms.len() > self.search.given);
        let (value, from) = match repeated {
            Some(value) => (value, "repeated periods"),
            None if above == 0.0 => (found.rms(ALL), "what the identified model leaves"),
            None => (noise.innovation, "what the residual's own past does not predict"),
        };
        let autocorrelation = noise.coefficients.first().copied().unwrap_or(0.0);
        let unit = self.case.plant.plant.position_unit.clone();
        (above, NoiseFloor { value, unit, from: from.into(), autocorrelation })
    }

    /// The unit of a hidden state, which nothing determines, is open among the plant's own parameters: a threshold in that
    /// unit is given beside them.
    fn covariance(&self, found: &Fitted<Model>) -> Symmetric {
        let rest = found.residual(self.data).unwrap_or_default();
        let noise = autoregression(&rest, &self.data.runs);
        let model = &found.model;
        let own = (0..model.values.len()).filter(|k| model.plant.is_free(*k)).count();
        covariance(found, self.data, &noise, own)
    }
}

/// Free run of another recording: its first rows say where its states begin, as far as the plant leaves that open.
fn held_out(recording: &DynamicRecording, fitted: &Fitted<Model>) -> Vec<Vec<f64>> {
    let still = || vec![numerics::mean(&recording.positions[0]); recording.rows()];
    let run = || {
        let (model, data) = (fitted.model.fixed(), Data::new(recording));
        let rows = if recording.unscored() == 0 { STEADY_ROWS } else { recording.unscored() };
        let first = vec![fitted.states[0].clone(); data.runs.len()];
        let states = fit(&model, &first, &data.clone().head(rows), ALL)?.states;
        model.positions(&states, &data).ok()
    };
    vec![run().unwrap_or_else(still)]
}

/// Where an effect comes from: the catalogue, the user's `own`, or a form without a name.
fn kind(own: &[Arc<MotionEffect>], catalogued: &[String], id: &str) -> &'static str {
    match id {
        id if catalogued.iter().any(|other| other == id) => CATALOGUED,
        id if own.iter().any(|own| own.text.id == id) => DECLARED,
        _ => EMPIRICAL,
    }
}
