//! One recording from rows to everything that is said of it.

use fitter::faults::BadRow;
use fitter::{Coefficients, Mirror, Recording};
use serde::Serialize;

use crate::condense::condense;
use crate::effects::{Effect, catalogue};
use crate::explain::{Explanation, explain};
use crate::hand_on;
use crate::held_out::{self, Fit, Score};
use crate::model::{self, Model};
use crate::observe::{ObserveError, Simulated, observe};
use crate::polish;
use crate::rows::{Rows, mean, rms};
use crate::screened::Screened;
use crate::search::{Found, Term};
use crate::verdict::{self, Location, NamedEffect, Parameter, Verdict};

/// The noise floor.
#[derive(Debug, Clone, Serialize)]
pub struct NoiseFloor {
    /// Standard deviation of a reading.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// What it was measured from.
    pub from: String,
    /// Correlation of readings one typical gap apart.
    pub autocorrelation: f64,
}

/// The diagnosis of one recording, as it is written.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Version of the format.
    pub schema: u32,
    /// File name of the recording.
    pub recording: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The noise floor.
    pub noise_floor: NoiseFloor,
    /// Where the mismatch lives, the strongest first.
    pub locations: Vec<Location>,
    /// The named effects, the strongest first.
    pub effects: Vec<NamedEffect>,
    /// The proof.
    pub fit: Fit,
    /// What is not determined.
    pub unidentifiable: Vec<String>,
    /// What to record next.
    pub next_experiment: Option<String>,
    /// Cells of the recording that cannot be readings; their rows were left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bad_rows: Vec<BadRow>,
    /// What the check of the answer against itself withdrew or changed, a sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub judged: Vec<String>,
    /// Why no model was handed on; none where one was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub withheld: Option<String>,
    /// The identified parameters of the nominal plant; empty for a static recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plant: Vec<Parameter>,
}

/// A diagnosis with what the report and the coefficients file are made from.
pub struct Outcome {
    /// What is written.
    pub diagnosis: Diagnosis,
    /// The coefficients file.
    pub coefficients: Coefficients,
    /// The rows.
    pub rows: Rows,
    /// The base model alone.
    pub before: Model,
    /// The augmented model.
    pub after: Model,
    /// For every family of the search: place or effect, and −ln p beside the base.
    pub map: Vec<(String, f64)>,
}

/// What a diagnosis is asked for.
#[derive(Default)]
pub struct Options {
    /// Ids of effects that are left out of the catalogue.
    pub skip: Vec<String>,
    /// Most harmonics of a periodic error that are handed on; all that were found where none.
    pub harmonics: Option<usize>,
    /// The command, as it is to stand in the coefficients file.
    pub command: String,
}

/// Diagnoses a recording.
///
/// # Errors
/// [`ObserveError`] where the recording cannot be diagnosed at all.
pub fn diagnose(
    recording: &Recording,
    mirror: &Mirror,
    simulated: Option<&Simulated>,
    held_out: Option<&Recording>,
    options: &Options,
) -> Result<Outcome, ObserveError> {
    let screened = Screened::of(recording, mirror, simulated, held_out)?;
    let (recording, simulated, held_out) = screened.parts();
    let full = observe(recording, mirror, simulated)?;
    let condensed = condense(&full);
    let (rows, per_cell) = match condensed {
        Some(condensed) => (condensed.rows, condensed.per_cell),
        None => (full.clone(), 1.0),
    };
    let other = held_out.map(|r| observe(r, mirror, None).map(|rows| (r, rows))).transpose()?;
    let effects: Vec<Box<dyn Effect>> = catalogue();
    let explanation = explain(&rows, &effects, &options.skip);
    let (before, after) = rayon::join(
        || model::expected(&explanation, &effects),
        || {
            let found = !explanation.terms.is_empty();
            found.then(|| model::fit(&explanation, &effects, &explanation.terms, None))
        },
    );
    let after = after.unwrap_or_else(|| before.clone());
    let hand_on = |model: &Model| {
        let mut file = hand_on::coefficients(recording, mirror, &rows, &effects, model, &options.command);
        hand_on::describe(&mut file, &full);
        if let Some(most) = options.harmonics {
            polish::keep_strongest(&mut file, most);
        }
        if simulated.is_none() {
            polish::polish(&mut file, recording, &full);
        }
        file
    };
    // Generic curves hold nowhere else and are not handed on: the effects are fitted again without them.
    let coefficients = || {
        let is_named = |t: &&Term| explanation.search.effect(t.family).is_some();
        let named: Vec<Term> = explanation.terms.iter().filter(is_named).cloned().collect();
        if named.is_empty() {
            hand_on(&before)
        } else if named.len() < explanation.terms.len() {
            hand_on(&model::fit(&explanation, &effects, &named, None))
        } else {
            hand_on(&after)
        }
    };
    let ((said, coefficients, map), mut fit) = rayon::join(
        || (verdict::say(&explanation, &effects, &after), coefficients(), map(&explanation, &effects)),
        || held_out::prove(&explanation, &before, &after),
    );
    if per_cell > 1.0 {
        // Figures are of rows, not of cell means.
        let rms_of = |file: &Coefficients| score(recording, &full, file);
        fit.before.train_rms = rms_of(&hand_on(&before)).unwrap_or(fit.before.train_rms);
        fit.after.train_rms = rms_of(&coefficients).unwrap_or(fit.after.train_rms);
    }
    if let Some((other, other_rows)) = &other {
        let plain = hand_on(&before);
        fit.held_out_by = other.file.clone();
        fit.before = Score { held_out_rms: score(other, other_rows, &plain), ..fit.before };
        fit.after = Score { held_out_rms: score(other, other_rows, &coefficients), ..fit.after };
        fit.gain = None;
    }
    let from = if full.passes().len() > 1 { "repeated passes" } else { "blocks" };
    let mut unidentifiable = said.unidentifiable;
    unidentifiable.extend(screened.notes());
    if fit.after.held_out_rms.is_none() {
        unidentifiable.push(format!(
            "too short to hold anything out ({} readings, passes: {}): the improvement is shown on the fitted rows only",
            full.len(),
            full.passes().len()
        ));
    }
    let diagnosis = Diagnosis {
        schema: 1,
        recording: recording.file.clone(),
        verdict: said.verdict,
        noise_floor: NoiseFloor {
            value: explanation.search.noise.level * per_cell.sqrt(),
            unit: rows.unit.clone(),
            from: from.into(),
            autocorrelation: explanation.search.noise.correlation.typical(),
        },
        locations: said.locations,
        effects: said.effects,
        fit,
        unidentifiable,
        next_experiment: said.next_experiment,
        bad_rows: screened.bad_rows(),
        judged: Vec::new(),
        withheld: None,
        plant: Vec::new(),
    };
    Ok(Outcome { diagnosis, coefficients, rows, before, after, map })
}

/// For every family of the search its place or effect, and −ln p beside the base.
fn map(explanation: &Explanation, effects: &[Box<dyn Effect>]) -> Vec<(String, f64)> {
    let of = |found: &Found| {
        let place = verdict::place_of(explanation, effects, &found.term);
        let name = match &place.times {
            Some(times) => format!("{} × {times}", place.variable),
            None => place.variable,
        };
        (name, explanation.search.family_wise(found))
    };
    explanation.search.survey(&[]).iter().map(of).collect()
}

/// Root mean square of the corrected reading's error on another recording, its own offset removed.
fn score(other: &Recording, rows: &Rows, coefficients: &Coefficients) -> Option<f64> {
    let applied = fitter::apply(other, coefficients).ok()?;
    let per = coefficients.sensor.per_internal();
    let error: Vec<f64> = applied.corrected.iter().zip(&rows.truth).map(|(c, t)| c * per - t).collect();
    let offset = mean(&error);
    Some(rms(&error.iter().map(|e| e - offset).collect::<Vec<f64>>()))
}
