//! Recordings under feedback: an open-loop position would integrate the smallest error, so the drive is
//! what is predicted and scored, by the inverse model along the recorded motion.

pub mod filter;
mod findings;
pub mod inverse;
pub mod motion;
pub mod search;

use fitter::plant::Plant;

use super::data::Data;
use super::diagnose::{DynamicOutcome, Options, OwnSimulation, Predicted};
use super::effects::{CATALOGUE, COULOMB_FRICTION, DRIVE_LAG, DRIVE_OFFSET, DynamicEffect, Scale, effect};
use super::fault::DynamicError;
use super::recording::DynamicRecording;
use super::verdict::Units;
use super::{judge, plant, score};
use crate::diagnosis::{Diagnosis, NoiseFloor};
use crate::dynamic::data::SCORE;
use crate::held_out::{Fit, Score};
use crate::verdict::Verdict;
use inverse::{Inverse, Solved, best_cutoff, predict, solve};
use motion::Motion;
use search::Along;

/// Diagnoses a recording that was taken under feedback.
///
/// # Errors
/// One of [`DynamicError`].
pub fn diagnose(
    recording: &DynamicRecording,
    nominal: &Plant,
    simulated: Option<&OwnSimulation>,
    held_out: Option<&DynamicRecording>,
    options: &Options,
) -> Result<DynamicOutcome, DynamicError> {
    if let Some(term) = options.given.first() {
        let reason =
            "is given, and under feedback all effects are identified anew; leave it out of the plant";
        let id = term.effect.id.to_string();
        return Err(DynamicError::Effect { file: recording.file.clone(), id, reason: reason.into() });
    }
    let lost = || DynamicError::NoPlant { file: recording.file.clone(), percent: 100.0 };
    let data = Data::new(recording);
    let scale = data.scale;
    // The lag that is looked for first is that of the drive; under feedback it cannot be told from others.
    let mut catalogue: Vec<&'static dyn DynamicEffect> =
        CATALOGUE.iter().copied().filter(|e| options.skip.iter().all(|id| id != e.id)).collect();
    catalogue.sort_by_key(|e| e.id != DRIVE_LAG);
    let trial = Inverse {
        stiffness: true,
        terms: [COULOMB_FRICTION, DRIVE_OFFSET, DRIVE_LAG]
            .iter()
            .filter_map(|id| effect(id).map(|e| (e, e.starts(&scale)[0].clone())))
            .collect(),
    };
    let motion = Motion::new(recording, best_cutoff(recording, &trial), None);
    let per_row = (2.0 * motion.cutoff_hz * motion.step_s).min(1.0);
    let along = Along { motion: &motion, fold: &data.fold, per_row };
    let present = along.search(&catalogue, &scale).ok_or_else(lost)?;
    let nominal_inverse = Inverse { stiffness: present.stiffness, terms: Vec::new() };
    let all = |inverse: &Inverse| solve(inverse, &motion, &|_| true);
    let theirs = simulated.map(|own| expected(own, recording, &along, &scale)).transpose()?;
    let before = match &theirs {
        Some(solved) => solved.clone(),
        None => all(&nominal_inverse).ok_or_else(lost)?,
    };
    let proof = |inverse: &Inverse| solve(inverse, &motion, &|k| data.fold[k] as usize != SCORE);
    let proof_before = theirs.or_else(|| proof(&nominal_inverse));
    let found = present;
    judge::standing(recording, false, |withdrawn| {
        let mut present = found.clone();
        present.terms.retain(|(effect, _)| withdrawn.effects.iter().all(|id| id != effect.id));
        let after = all(&present).ok_or_else(lost)?;
        let proof_after = proof(&present);
        let effects = findings::named(&along, &present, &after, &catalogue, &scale, nominal);
        let explained = 1.0 - square(&after.residual) / square(&before.residual).max(f64::MIN_POSITIVE);
        let locations = findings::locations(&effects, explained, &motion);
        let own = predictions(recording, &motion, &before, &after);
        let other = held_out.map(|r| {
            let there = Motion::new(r, motion.cutoff_hz, Some(motion.slow()));
            predictions(r, &there, &before, &after)
        });
        let figures = |which: usize| -> Score {
            let pick = |p: &Predicted| if which == 0 { p.before[0].clone() } else { p.after[0].clone() };
            match held_out.zip(other.as_ref()) {
                Some((file, predicted)) => Score {
                    train_rms: score::rms(recording, &recording.drives[0], &pick(&own), |_| true)
                        .unwrap_or(0.0),
                    held_out_rms: score::rms(file, &file.drives[0], &pick(predicted), |_| true),
                },
                None => {
                    let solved = if which == 0 { &proof_before } else { &proof_after };
                    let there = solved.as_ref().map(|s| predict(&s.model, &motion));
                    let of = |wanted: &dyn Fn(usize) -> bool| {
                        there.as_ref().and_then(|y| score::rms(recording, &recording.drives[0], y, wanted))
                    };
                    Score {
                        train_rms: of(&|k| data.fold[k] as usize != SCORE).unwrap_or(0.0),
                        held_out_rms: of(&|k| data.fold[k] as usize == SCORE),
                    }
                }
            }
        };
        let fit = Fit {
            unit: nominal.drive_unit.clone(),
            held_out_by: held_out.map_or("block".into(), |r| r.file.clone()),
            before: figures(0),
            after: figures(1),
            gain: None,
            of_explainable: None,
        };
        let verdict = if effects.is_empty() {
            Verdict::Consistent
        } else if findings::coloured(&after.residual, &motion) {
            Verdict::PartlyExplained
        } else {
            Verdict::Explained
        };
        let mut unidentifiable = vec![
            "the controller: position and drive determine the mechanism, not what drove it".to_string(),
            "inertia and the drive's unit: everything is per inertia".to_string(),
            // The controller answers to the reading noise, so that regressors and drive share it: curves without physics
            // explain two fifths of what is left where there is nothing.
            "structure of no known effect: under feedback it is not told from what the reading noise makes"
                .to_string(),
        ];
        if !present.stiffness {
            unidentifiable.push("stiffness: none that this recording shows; it is left at zero".into());
        }
        let units = Units { position: nominal.position_unit.clone(), drive: nominal.drive_unit.clone() };
        let deviations = [0, 1, 2].map(|k| after.deviations[0].get(k).copied().unwrap_or(0.0));
        let mut plant = super::verdict::nominal(after.model.nominal, deviations, &units);
        plant.retain(|p| present.stiffness || p.name != "stiffness");
        let diagnosis = Diagnosis {
            schema: 1,
            recording: recording.file.clone(),
            verdict,
            noise_floor: NoiseFloor {
                value: square(&after.residual).sqrt(),
                unit: nominal.drive_unit.clone(),
                from: format!("what the inverse model leaves below {:.0} Hz", motion.cutoff_hz),
                autocorrelation: 0.0,
            },
            next_experiment: super::verdict::next_experiment(verdict, &effects, &locations),
            locations,
            effects,
            fit,
            unidentifiable,
            bad_rows: recording.bad_rows.clone(),
            judged: Vec::new(),
            withheld: None,
            plant,
        };
        Ok(DynamicOutcome { diagnosis, plant: plant::to_file(&after.model, nominal), own, other, idle: None })
    })
}

/// The mechanism that the user's simulation states: inertia, damping and stiffness by which its motion goes
/// with the recorded drive, and what that leaves of the drive along the recorded motion.
fn expected(
    own: &OwnSimulation,
    recording: &DynamicRecording,
    along: &Along,
    scale: &Scale,
) -> Result<Solved, DynamicError> {
    let wrong =
        |found: String, expected: String| DynamicError::Simulated { file: own.file.clone(), found, expected };
    if own.positions.len() != recording.rows() {
        return Err(wrong(format!("{} rows", own.positions.len()), format!("{} rows", recording.rows())));
    }
    let copy = DynamicRecording { positions: vec![own.positions.clone()], ..recording.clone() };
    let motion = Motion::new(&copy, along.motion.cutoff_hz, Some(along.motion.slow()));
    let theirs = Along { motion: &motion, fold: along.fold, per_row: along.per_row };
    let solved = theirs.search(&[], scale).and_then(|inverse| solve(&inverse, &motion, &|_| true));
    let solved = solved.ok_or_else(|| {
        wrong("a position that does not move".into(), "the motion that the recorded drive causes".into())
    })?;
    let predicted = along.motion.smooth(&predict(&solved.model, along.motion));
    let residual = along.motion.drive.iter().zip(&predicted).map(|(u, p)| u - p).collect();
    Ok(Solved { residual, ..solved })
}

fn square(residual: &[f64]) -> f64 {
    crate::rows::rms(residual).powi(2)
}

fn predictions(recording: &DynamicRecording, motion: &Motion, before: &Solved, after: &Solved) -> Predicted {
    Predicted {
        t_s: recording.t_s.clone(),
        before: vec![predict(&before.model, motion)],
        after: vec![predict(&after.model, motion)],
    }
}
