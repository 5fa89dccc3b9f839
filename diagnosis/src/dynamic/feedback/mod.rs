//! Recordings under feedback: an open-loop position would integrate the smallest error, so the drive is
//! what is predicted and scored, by the inverse model along the recorded motion.

pub mod errors;
pub mod filter;
mod findings;
pub mod inverse;
pub mod motion;
pub mod search;

use super::data::Data;
use super::diagnose::{Case, DynamicOutcome, Identified, OwnSimulation, Predicted};
use super::effects::{
    COULOMB_FRICTION, DRIVE_LAG, DRIVE_OFFSET, DynamicEffect, Scale, effect, under_feedback,
};
use super::joint::feedback::Inverse;
use super::judge::{self, Problem, Withdrawn};
use super::model::{Model, Term};
use super::recording::DynamicRecording;
use super::verdict::{self, locations};
use super::{plant, score};
use crate::DiagnosisError;
use crate::diagnosis::{Diagnosis, NoiseFloor};
use crate::dynamic::data::SCORE;
use crate::verdict::{Said, Verdict};
use errors::deviations;
use inverse::{Solved, best_cutoff, mechanism, predict, solve};
use motion::Motion;
use search::Along;

/// Diagnoses a recording that was taken under feedback.
///
/// # Errors
/// One of [`DiagnosisError`].
pub fn diagnose(case: &Case) -> Result<DynamicOutcome, DiagnosisError> {
    let Case { recording, simulated, options, .. } = *case;
    if let Some(term) = options.given.first() {
        let reason =
            "is given, and under feedback all effects are identified anew; leave it out of the plant";
        let id = term.effect.id.to_string();
        return Err(DiagnosisError::Effect { file: recording.file.clone(), id, reason: reason.into() });
    }
    let lost = || recording.lost(100.0);
    let data = Data::new(recording);
    let scale = data.scale;
    // The lag that is looked for first is that of the drive; under feedback it cannot be told from others.
    let mut catalogue: Vec<&'static DynamicEffect> =
        under_feedback().filter(|e| options.skip.iter().all(|id| id != e.id)).collect();
    catalogue.sort_by_key(|e| e.id != DRIVE_LAG);
    let motion = Motion::new(recording, options.cutoff_hz.unwrap_or_else(|| cutoff(recording)), None);
    let along = Along { motion: &motion, fold: &data.fold, per_row: motion.independent_per_row() };
    let present = along.search(&catalogue, &scale).and_then(|found| plausible(found, &motion, &scale));
    let present = present.ok_or_else(lost)?;
    let without = mechanism(present.nominal_free[1]);
    let theirs = simulated.map(|own| expected(own, recording, &along, &scale)).transpose()?;
    let before = match &theirs {
        Some(solved) => solved.clone(),
        None => solve(&without, &motion, &|_| true).ok_or_else(lost)?,
    };
    let proof_before = theirs.or_else(|| without_score(&without, &motion, &data));
    judge::standing(&Feedback { case, data: &data, along, catalogue, found: present, before, proof_before })
}

/// The frequency up to which a motion under feedback is looked at, Hz.
pub fn cutoff(recording: &DynamicRecording) -> f64 {
    best_cutoff(recording, &Model { terms: usual_terms(recording), ..mechanism(true) })
}

/// What every drive has some of: dry friction, an offset, a lag.
pub fn usual_terms(recording: &DynamicRecording) -> Vec<Term> {
    let scale = Data::new(recording).scale;
    let term = |id: &str| effect(id).map(|e| Term::new(e, (e.starts)(&scale)[0].clone()));
    [COULOMB_FRICTION, DRIVE_OFFSET, DRIVE_LAG].into_iter().filter_map(term).collect()
}

/// The model without effects that all rows together deny: the search has fitted them to some. An effect with a simpler one as its
/// special case becomes that.
fn plausible(mut model: Model, motion: &Motion, scale: &Scale) -> Option<Model> {
    loop {
        let solved = solve(&model, motion, &|_| true)?.model;
        let denied = |term: &Term| !(term.effect.plausible)(&term.parameters, scale);
        let Some(k) = solved.terms.iter().position(denied) else { return Some(model) };
        let simpler = solved.terms[k]
            .effect
            .special_case
            .filter(|simpler| solved.terms.iter().all(|term| term.effect.id != simpler.id));
        match simpler {
            Some(simpler) => model.terms[k] = Term::new(simpler, (simpler.starts)(scale)[0].clone()),
            None => drop(model.terms.remove(k)),
        }
    }
}

/// A model fitted without the rows that score.
fn without_score(shapes: &Model, motion: &Motion, data: &Data) -> Option<Solved> {
    solve(shapes, motion, &|k| data.fold[k] as usize != SCORE)
}

/// A motion under feedback, and what was found along it.
struct Feedback<'a> {
    case: &'a Case<'a>,
    data: &'a Data<'a>,
    along: Along<'a>,
    catalogue: Vec<&'static DynamicEffect>,
    found: Model,
    /// The mechanism without effects, fitted to all rows, and without those that score.
    before: Solved,
    proof_before: Option<Solved>,
}

impl Problem for Feedback<'_> {
    fn case(&self) -> &Case<'_> {
        self.case
    }

    fn answer(&self, withdrawn: &Withdrawn) -> Result<DynamicOutcome, DiagnosisError> {
        let (recording, nominal, before) = (self.case.recording, &self.case.plant.plant, &self.before);
        let motion = self.along.motion;
        let mut present = self.found.clone();
        present.terms.retain(|t| withdrawn.effects.iter().all(|id| id != t.effect.id));
        let after = solve(&present, motion, &|_| true).ok_or_else(|| recording.lost(100.0))?;
        let deviations = deviations(&after, motion, self.case.options.same_motion);
        let of_terms = (&after.model.terms[..], &deviations[1..]);
        let effects =
            findings::named(&self.along, &present, of_terms, &self.catalogue, &self.data.scale, nominal);
        let explained =
            1.0 - (motion.rms(&after.residual) / motion.rms(&before.residual).max(f64::MIN_POSITIVE)).powi(2);
        let locations = locations(|variable| motion.reach(variable), &effects, explained, &[]);
        let models = [&before.model, &after.model];
        let own = Predicted::by(recording, models, |model| vec![predict(model, motion)]);
        let other = self.case.held_out.map(|r| {
            let there = Motion::new(r, motion.cutoff_hz, Some(motion.slow));
            Predicted::by(r, models, |model| vec![predict(model, &there)])
        });
        let predicted = |solved: &Option<Solved>| solved.as_ref().map(|s| predict(&s.model, motion));
        let proof_after = without_score(&present, motion, self.data);
        let without = [predicted(&self.proof_before), predicted(&proof_after)];
        let channels: score::Channels = |recording| &recording.drives;
        let fit = score::fit(
            self.case,
            (channels, &nominal.drive_unit),
            &own,
            other.as_ref(),
            without,
            &self.data.fold,
        );
        let verdict = if effects.is_empty() {
            Verdict::Consistent
        } else if findings::coloured(&after.residual, motion) {
            Verdict::PartlyExplained
        } else {
            Verdict::Explained
        };
        let floor = NoiseFloor {
            value: motion.rms(&after.residual),
            unit: nominal.drive_unit.clone(),
            from: format!("what the inverse model leaves below {:.0} Hz", motion.cutoff_hz),
            autocorrelation: 0.0,
        };
        let of_plant = [0, 1, 2].map(|k| deviations[0][k]);
        let mut plant = verdict::nominal(after.model.nominal, of_plant, nominal);
        plant.retain(|p| present.nominal_free[1] || p.name != "stiffness");
        let said = Said {
            verdict,
            next_experiment: verdict::next_experiment(verdict, &effects, &locations, &verdict::experiment),
            locations,
            effects,
            unidentifiable: unidentifiable(present.nominal_free[1]),
        };
        let diagnosis = Diagnosis { plant, ..self.case.said(said, floor, fit) };
        Ok(DynamicOutcome {
            diagnosis,
            plant: plant::to_file(&after.model, nominal),
            own,
            other,
            idle: None,
            identified: Identified::Inverse(Inverse {
                model: after.model,
                cutoff_hz: motion.cutoff_hz,
                slow: motion.slow,
            }),
        })
    }
}

/// What no recording under feedback determines, and what not this one.
fn unidentifiable(stiffness: bool) -> Vec<String> {
    let always = [
        "the controller: position and drive determine the mechanism, not what drove it",
        "inertia and the drive's unit: everything is per inertia",
        // The controller answers to the reading noise, so that regressors and drive share it: curves without physics
        // explain two fifths of what is left where there is nothing.
        "structure of no known effect: under feedback it is not told from what the reading noise makes",
    ];
    let none = "stiffness: none that this recording shows; it is left at zero";
    always.into_iter().chain((!stiffness).then_some(none)).map(String::from).collect()
}

/// The mechanism that the user's simulation states: inertia, damping and stiffness by which its motion goes
/// with the recorded drive, and what that leaves of the drive along the recorded motion.
fn expected(
    own: &OwnSimulation,
    recording: &DynamicRecording,
    along: &Along,
    scale: &Scale,
) -> Result<Solved, DiagnosisError> {
    let motion = Motion::new(&own.in_place(recording)?, along.motion.cutoff_hz, Some(along.motion.slow));
    let theirs = Along { motion: &motion, fold: along.fold, per_row: along.per_row };
    let solved = theirs.search(&[], scale).and_then(|shapes| solve(&shapes, &motion, &|_| true));
    let solved = solved.ok_or_else(|| {
        own.wrong("a position that does not move".into(), "the motion that the recorded drive causes".into())
    })?;
    let predicted = along.motion.smooth(&predict(&solved.model, along.motion));
    let residual = along.motion.drive.iter().zip(&predicted).map(|(u, p)| u - p).collect();
    Ok(Solved { residual, ..solved })
}
