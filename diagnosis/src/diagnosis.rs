//! One recording from rows to everything that is said of it.

use fitter::coefficients::{Correlation, Diagnosed, Recorded};
use fitter::faults::{BadRow, left};
use fitter::{Coefficients, Mirror, Recording};
use numerics::{mean, rms};
use serde::Serialize;

use crate::attempt::{self, Attempt};
use crate::compose;
use crate::condense::{Condensed, condense};
use crate::effects::{Effect, Place, catalogue};
use crate::error::DiagnosisError;
use crate::explain::{Explanation, Outset};
use crate::fleet::Forced;
use crate::generic;
use crate::hand_on::HandOn;
use crate::held_out::{Fit, Score};
use crate::judge::Settled;
use crate::model::{FittedTerm, Model};
use crate::observe::{Simulated, Wanted, observe};
use crate::refit;
use crate::rows::Rows;
use crate::screened::{Screened, Seen};
use crate::verdict::{self, Location, NamedEffect, Parameter, Said, Verdict};

/// The noise floor.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
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
#[non_exhaustive]
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

impl Diagnosis {
    /// An answer as it is before it is held against itself.
    pub(crate) fn of(file: &str, said: Said, noise_floor: NoiseFloor, fit: Fit) -> Diagnosis {
        Diagnosis {
            schema: 1,
            recording: file.into(),
            verdict: said.verdict,
            noise_floor,
            locations: said.locations,
            effects: said.effects,
            fit,
            unidentifiable: said.unidentifiable,
            next_experiment: said.next_experiment,
            bad_rows: Vec::new(),
            judged: Vec::new(),
            withheld: None,
            plant: Vec::new(),
        }
    }
}

/// A diagnosis with what the report and the coefficients file are made from.
pub struct Outcome {
    /// What is written.
    pub diagnosis: Diagnosis,
    /// The coefficients file; none where it is withheld.
    pub coefficients: Option<Coefficients>,
    /// The rows.
    pub rows: Rows,
    /// The base model alone.
    pub before: Model,
    /// The model that is handed on.
    pub after: Model,
    /// What was found, the named first.
    pub(crate) found: Vec<FoundTerm>,
    /// What the recording says of every effect, named or not, where that was asked.
    pub forced: Option<Forced>,
}

/// Something that was found in a recording, for a comparison with another.
pub(crate) struct FoundTerm {
    /// Its family in the search.
    pub family: usize,
    /// The effect; none of structure without a name.
    pub effect: Option<Effect>,
    /// Where it lives.
    pub place: Place,
    /// Its shape.
    pub shape: Vec<f64>,
    /// Family-wise p-value.
    pub p_value: f64,
    /// Sum of squares that it alone explains, in units of the noise.
    pub explained: f64,
    /// The part of it that other recordings are expected to have.
    pub reach: f64,
    /// What it adds to the error at every row.
    pub contribution: Vec<f64>,
}

/// What a diagnosis is asked for.
#[derive(Default)]
pub struct Options {
    /// Ids of effects that are left out of the catalogue.
    pub skip: Vec<String>,
    /// Effects that take part beside the catalogue.
    pub declared: Vec<Effect>,
    /// The base, where it is not to be chosen.
    pub base: Wanted,
    /// Most harmonics of a periodic error that are handed on; all that were found where none.
    pub harmonics: Option<usize>,
    /// Whether every effect is fitted, named or not, as a fleet needs it.
    pub forced: bool,
    /// The command, as it is to stand in the coefficients file.
    pub command: String,
}

/// Diagnoses a recording.
///
/// # Errors
/// [`DiagnosisError`] where the recording cannot be diagnosed at all.
pub fn diagnose(
    recording: &Recording,
    mirror: &Mirror,
    simulated: Option<&Simulated>,
    held_out: Option<&Recording>,
    options: &Options,
) -> Result<Outcome, DiagnosisError> {
    let screened = Screened::of(recording, mirror, simulated, held_out)?;
    let (outcome, far_out) = of_readings(&screened, mirror, options)?;
    if far_out.is_empty() {
        return Ok(outcome);
    }
    // A model of which single readings are far out was fitted to them as well: once more without.
    Ok(of_readings(&screened.without(far_out), mirror, options)?.0)
}

/// The diagnosis of rows that are readings as far as the screen can tell, and those that it left far out.
fn of_readings(
    screened: &Screened<'_>,
    mirror: &Mirror,
    options: &Options,
) -> Result<(Outcome, Vec<(usize, BadRow)>), DiagnosisError> {
    let (seen, simulated, held_out) = screened.parts();
    let recording = seen.recording;
    let full = observe(recording, mirror, simulated, options.base)?;
    let Condensed { mut rows, cell_of } = condense(&full);
    generic::keep_strongest_columns(&mut rows);
    let (rows, cell_of) = (&rows, &cell_of);
    let other = held_out
        .map(|r| observe(r.recording, mirror, None, options.base).map(|rows| (r, rows)))
        .transpose()?;
    let mut effects: Vec<Effect> = catalogue(&mirror.sensor).to_vec();
    effects.extend(options.declared.iter().cloned());
    let hand_on = HandOn {
        seen,
        mirror,
        full: &full,
        rows,
        outset: &Outset::of(rows),
        cell_of,
        catalogue: &effects,
        harmonics: options.harmonics,
        command: &options.command,
        simulated: simulated.is_some(),
    };
    let accuracy = mirror.reference.accuracy.filter(|_| rows.pair);
    let named =
        attempt::best(&hand_on, &options.skip, accuracy).map_err(|reason| unusable(recording, reason))?;
    let wider = compose::with_forms(&effects, &named, hand_on.outset, &mirror.sensor);
    let hand_on = HandOn { catalogue: &wider, ..hand_on };
    let described = match wider.len() > effects.len() {
        true => attempt::with_forms(&hand_on, &options.skip, accuracy, named)
            .map_err(|reason| unusable(recording, reason))?,
        false => named,
    };
    let curved = compose::with_curves(&effects, &described, &mirror.sensor);
    let with_curves = HandOn { catalogue: &curved, ..hand_on };
    let best = match curved.len() > effects.len() {
        true => attempt::with_curves(&with_curves, &options.skip, accuracy, described, effects.len()),
        false => described,
    };
    let Attempt { explanation, before, before_file, mut settled, mut fit, noise_floor, mut said, .. } = best;
    let hand_on = HandOn { catalogue: explanation.search.catalogue, ..hand_on };
    let mut file = handed_on(&hand_on, &settled);
    if let Some((other, other_rows)) = &other {
        score_on(other, other_rows, &mut fit, &before_file, file.as_ref().ok());
    }
    said.unidentifiable.extend(screened.notes());
    if fit.after.held_out_rms.is_none() {
        said.unidentifiable.push(too_short(&full));
    }
    compose::number(&mut said, &mut settled.judged, file.as_mut().ok());
    let (coefficients, withheld) = match file {
        Ok(mut file) => {
            let correlation = whitened(&explanation);
            file.set_recorded(Recorded { correlation, ..Recorded::of(recording, mirror.reference, &[]) });
            (Some(with_diagnosis(file, &said, &fit, &noise_floor)), None)
        }
        Err(reason) => (None, Some(reason)),
    };
    let found = found_terms(&explanation, &settled);
    let diagnosis = Diagnosis {
        bad_rows: screened.bad_rows(),
        judged: settled.judged,
        withheld,
        ..Diagnosis::of(&recording.file, said, noise_floor, fit)
    };
    // Of means of rows no single reading is known, and where structure is left none is far out of noise.
    let explained = !matches!(diagnosis.verdict, Verdict::PartlyExplained | Verdict::Unexplained);
    let far_out = match explained && rows.len() == full.len() {
        true => left::beyond_noise(recording, &settled.left, &explanation.search.noise.sigma),
        false => Vec::new(),
    };
    let forced = options.forced.then(|| Forced::of(&explanation, &settled.joint));
    let after = settled.handed;
    Ok((Outcome { diagnosis, coefficients, rows: rows.clone(), before, after, found, forced }, far_out))
}

/// The coefficients file of what is handed on, or why there is none.
fn handed_on(hand_on: &HandOn, settled: &Settled) -> Result<Coefficients, String> {
    if hand_on.simulated {
        return Err(
            "the model holds beside your own simulation only, which no coefficients file holds".into()
        );
    }
    hand_on.mean(&settled.refitted, &settled.handed, &settled.instead)
}

/// The correlation of the noise, of which the covariance knows: it is that of rows made white.
fn whitened(explanation: &Explanation) -> Option<Correlation> {
    let typical = explanation.search.noise.correlation.typical();
    (typical > 0.0).then_some(Correlation { neighbours: typical, of_fitted: 1.0 })
}

/// What is said where no rows can be held out.
fn too_short(rows: &Rows) -> String {
    format!(
        "too short to hold anything out ({} readings, passes: {}): the improvement is shown on the fitted rows only",
        rows.len(),
        rows.passes().len()
    )
}

fn found_terms(explanation: &Explanation, settled: &Settled) -> Vec<FoundTerm> {
    let catalogue = explanation.search.catalogue;
    let of = |term: &FittedTerm| {
        let same = |t: &&FittedTerm| t.term.family == term.term.family && t.term.shape == term.term.shape;
        FoundTerm {
            family: term.term.family,
            effect: term.effect.map(|e| catalogue[e].clone()),
            place: verdict::place_of(explanation, catalogue, &term.term),
            shape: term.term.shape.clone(),
            p_value: verdict::p_value(&explanation.search, term),
            explained: term.explained,
            reach: settled.handed.terms.iter().find(same).map_or(1.0, |handed| handed.reach),
            contribution: term.contribution.clone(),
        }
    };
    settled.joint.terms.iter().map(of).collect()
}

/// The coefficients with what the diagnosis says of them.
fn with_diagnosis(file: Coefficients, said: &Said, fit: &Fit, noise_floor: &NoiseFloor) -> Coefficients {
    let diagnosis = Diagnosed {
        verdict: said.verdict.word().into(),
        before_rms: fit.before.held_out_rms.unwrap_or(fit.before.train_rms),
        after_rms: fit.after.held_out_rms.unwrap_or(fit.after.train_rms),
        noise_floor: noise_floor.value,
    };
    Coefficients { diagnosis: Some(diagnosis), ..file }
}

/// Puts what base and model, as handed on, leave of another recording in the place of the held-out figures.
fn score_on(
    other: &Seen<'_>,
    rows: &Rows,
    fit: &mut Fit,
    before: &Coefficients,
    after: Option<&Coefficients>,
) {
    let offset = |file: &Coefficients| score(other, rows, file);
    fit.held_out_by = other.recording.file.clone();
    fit.before = Score { held_out_rms: offset(before), ..fit.before };
    fit.after = Score { held_out_rms: after.and_then(offset), ..fit.after };
    fit.gain = None;
}

/// The error of a recording of which not even the base makes a model.
fn unusable(recording: &Recording, reason: String) -> DiagnosisError {
    DiagnosisError::NoModel { file: recording.file.clone(), reason }
}

/// Root mean square of the corrected reading's error on another recording, its own offset removed.
fn score(other: &Seen<'_>, rows: &Rows, coefficients: &Coefficients) -> Option<f64> {
    let error = refit::errors(coefficients, other, rows)?;
    let offset = mean(&error);
    Some(rms(&error.iter().map(|e| e - offset).collect::<Vec<f64>>()))
}
