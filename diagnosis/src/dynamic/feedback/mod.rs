//! Recordings under feedback: an open-loop position would integrate the smallest error, so the drive is
//! what is predicted and scored, by the inverse model along the recorded motion.

pub mod filter;
pub mod inverse;
pub mod motion;

use fitter::plant::Plant;
use rayon::prelude::*;

use super::data::{CHOOSE, Data, FIT, SCORE};
use super::diagnose::{DynamicOutcome, Options, Predicted};
use super::effects::{CATALOGUE, DynamicEffect, Part, effect, unit_of};
use super::fault::DynamicError;
use super::recording::DynamicRecording;
use super::verdict::p_value;
use super::{plant, score};
use crate::diagnosis::{Diagnosis, NoiseFloor};
use crate::held_out::{Fit, Score};
use crate::linear::dot;
use crate::rows::range;
use crate::verdict::{Location, NamedEffect, Parameter, Verdict};
use inverse::{Inverse, Solved, best_cutoff, is_lag, predict, solve};
use motion::Motion;

/// Part of the residual's variance that an effect has to explain: the regressors are themselves measured
/// and smoothed, and what they are wrong by looks like a small effect.
const LEAST_PART: f64 = 0.05;
/// −2 log likelihood that an effect has to gain.
const LEAST_GAIN: f64 = 30.0;
/// Standard errors by which an effect has to help on average over the blocks that did not fit it.
const CONSISTENT: f64 = 3.5;
/// Part of the variance by which an alternative may fall short.
const ALTERNATIVE: f64 = 0.02;

/// The search along one motion.
struct Along<'a> {
    motion: &'a Motion,
    fold: &'a [u8],
    /// Independent readings per row.
    per_row: f64,
}

impl Along<'_> {
    /// Mean square of a residual on one kind of row.
    fn square(&self, residual: &[f64], fold: usize) -> f64 {
        let rows = residual.iter().zip(self.fold).filter(|(_, f)| **f as usize == fold);
        let (sum, count) = rows.fold((0.0, 0usize), |(s, n), (r, _)| (s + r * r, n + 1));
        sum / count.max(1) as f64
    }

    fn fit(&self, inverse: &Inverse) -> Option<Solved> {
        solve(inverse, self.motion, &|k| self.fold[k] as usize == FIT)
    }

    /// −2 log likelihood gained on one kind of row.
    fn gain(&self, before: &Solved, after: &Solved, fold: usize) -> f64 {
        let rows = self.fold.iter().filter(|f| **f as usize == fold).count() as f64 * self.per_row;
        let (a, b) = (self.square(&before.residual, fold), self.square(&after.residual, fold));
        rows * (a.max(f64::MIN_POSITIVE) / b.max(f64::MIN_POSITIVE)).ln()
    }

    /// How surely the effect helps: mean over the blocks that did not fit of what it takes off the squared
    /// residual, in standard errors of that mean. Neighbouring rows of a residual are not independent,
    /// blocks nearly are.
    fn consistency(&self, before: &Solved, after: &Solved) -> f64 {
        let mut blocks: Vec<f64> = Vec::new();
        let mut last = usize::MAX;
        for (k, fold) in self.fold.iter().enumerate() {
            let fold = *fold as usize;
            if fold != FIT {
                if last != fold {
                    blocks.push(0.0);
                }
                if let Some(block) = blocks.last_mut() {
                    *block += before.residual[k].powi(2) - after.residual[k].powi(2);
                }
            }
            last = fold;
        }
        let count = blocks.len() as f64;
        let mean = crate::rows::mean(&blocks);
        let square = blocks.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        mean / (square / count).sqrt().max(f64::MIN_POSITIVE)
    }

    fn worth(&self, before: &Solved, after: &Solved) -> bool {
        let part = |fold| 1.0 - self.square(&after.residual, fold) / self.square(&before.residual, fold);
        self.gain(before, after, FIT) > LEAST_GAIN
            && self.gain(before, after, CHOOSE) > 0.25 * LEAST_GAIN
            && part(FIT) > LEAST_PART
            && part(CHOOSE) > LEAST_PART
            && self.consistency(before, after) > CONSISTENT
    }

    /// A model with one more effect, its shapes refined.
    fn with(
        &self,
        present: &Inverse,
        effect: &'static dyn DynamicEffect,
        start: &[f64],
    ) -> Option<(Inverse, Solved)> {
        let build = |shapes: &[f64]| {
            let mut inverse = present.clone();
            inverse.terms.push((effect, shapes.to_vec()));
            inverse
        };
        let mut shapes = start.to_vec();
        let mut best = self.fit(&build(&shapes))?;
        let shaped: Vec<usize> = (0..shapes.len())
            .filter(|j| effect.parameters()[*j].shape && !is_lag(effect) && effect.creep() != Some(*j))
            .collect();
        let mut width = 1.5;
        for _ in 0..if shaped.is_empty() { 0 } else { 6 } {
            for &j in &shaped {
                for factor in [width, 1.0 / width] {
                    let mut tried = shapes.clone();
                    tried[j] *= factor;
                    if let Some(s) = self.fit(&build(&tried))
                        && self.square(&s.residual, FIT) < self.square(&best.residual, FIT)
                    {
                        (shapes, best) = (tried, s);
                    }
                }
            }
            width = 1.0 + 0.6 * (width - 1.0);
        }
        Some((build(&shapes), best))
    }

    /// The rows that fit of a column.
    fn fit_rows(&self, column: &[f64]) -> Vec<f64> {
        column.iter().zip(self.fold).filter(|(_, f)| **f as usize == FIT).map(|(c, _)| *c).collect()
    }

    /// Adds a column to an orthonormal basis on the rows that fit.
    fn extend(&self, basis: &mut Vec<Vec<f64>>, column: Vec<f64>) {
        let mut own = self.fit_rows(&column);
        let before = dot(&own, &own);
        for _ in 0..2 {
            for b in basis.iter() {
                let along = dot(&own, b);
                crate::linear::add_scaled(&mut own, -along, b);
            }
        }
        let square = dot(&own, &own);
        if square > 1e-10 * before && square > 0.0 {
            let norm = square.sqrt();
            own.iter_mut().for_each(|v| *v /= norm);
            basis.push(own);
        }
    }

    /// What further columns explain of a residual, beside a basis.
    fn explained(
        &self,
        basis: &[Vec<f64>],
        residual: &[f64],
        columns: impl Iterator<Item = Vec<f64>>,
    ) -> f64 {
        let residual = self.fit_rows(residual);
        let mut all = basis.to_vec();
        columns.for_each(|c| self.extend(&mut all, c));
        all[basis.len()..].iter().map(|b| dot(&residual, b).powi(2)).sum()
    }

    /// All effects of a catalogue beside a model, the best first; equal ones in the catalogue's order.
    fn contenders(
        &self,
        present: &Inverse,
        catalogue: &[&'static dyn DynamicEffect],
        scale: &super::effects::Scale,
    ) -> Vec<(Inverse, Solved)> {
        let Some(solved) = self.fit(present) else { return Vec::new() };
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for column in inverse::model_columns(present, &solved, self.motion) {
            self.extend(&mut basis, column);
        }
        let lagging = present.terms.iter().any(|(e, _)| is_lag(*e));
        let offset = present.terms.iter().any(|(e, _)| matches!(e.part(), Part::Drive | Part::SensorOffset));
        let one = |e: &&'static dyn DynamicEffect| -> Option<(Inverse, Solved)> {
            let constant = matches!(e.part(), Part::Drive | Part::SensorOffset);
            let known = present.terms.iter().any(|(p, _)| p.id() == e.id());
            if known
                || (is_lag(*e) && lagging)
                || (constant && offset)
                || e.id() == "drive_saturation"
                || (e.part() == Part::SensorOffset && !present.stiffness)
            {
                return None;
            }
            let starts = e.starts(scale);
            let start = if starts.len() == 1 || is_lag(*e) {
                &starts[0]
            } else {
                // The start whose columns explain most of the residual.
                let explained = |start: &Vec<f64>| -> f64 {
                    let gain = solved.model.nominal[2];
                    let columns = inverse::effect_columns(*e, start, self.motion, gain);
                    self.explained(&basis, &solved.residual, columns.into_iter().map(|(_, c)| c))
                };
                starts.iter().map(|s| (explained(s), s)).max_by(|a, b| a.0.total_cmp(&b.0))?.1
            };
            let (inverse, solved) = self.with(present, *e, start)?;
            let parameters = &solved.model.terms.last()?.parameters;
            e.plausible(parameters, scale).then_some((inverse, solved))
        };
        let mut found: Vec<(Inverse, Solved)> = catalogue.par_iter().filter_map(one).collect();
        found.sort_by(|a, b| {
            self.square(&a.1.residual, CHOOSE).total_cmp(&self.square(&b.1.residual, CHOOSE))
        });
        found
    }
}

/// Diagnoses a recording that was taken under feedback.
///
/// # Errors
/// One of [`DynamicError`].
pub fn diagnose(
    recording: &DynamicRecording,
    nominal: &Plant,
    held_out: Option<&DynamicRecording>,
    options: &Options,
) -> Result<DynamicOutcome, DynamicError> {
    let lost = || DynamicError::NoPlant { file: recording.file.clone(), percent: 100.0 };
    let data = Data::new(recording);
    let scale = data.scale;
    // The lag that is looked for first is that of the drive; under feedback it cannot be told from others.
    let mut catalogue: Vec<&'static dyn DynamicEffect> =
        CATALOGUE.iter().copied().filter(|e| options.skip.iter().all(|id| id != e.id())).collect();
    catalogue.sort_by_key(|e| e.id() != "drive_lag");
    let trial = Inverse {
        stiffness: true,
        terms: ["coulomb_friction", "drive_offset", "drive_lag"]
            .iter()
            .filter_map(|id| effect(id).map(|e| (e, e.starts(&scale)[0].clone())))
            .collect(),
    };
    let motion = Motion::new(recording, best_cutoff(recording, &trial), None);
    let per_row = (2.0 * motion.cutoff_hz * motion.step_s).min(1.0);
    let along = Along { motion: &motion, fold: &data.fold, per_row };
    let mut present = Inverse { stiffness: false, terms: Vec::new() };
    let mut solved = along.fit(&present).ok_or_else(lost)?;
    loop {
        let contenders = along.contenders(&present, &catalogue, &scale);
        // A stiffness is nominal physics: it is taken where it helps more than any effect.
        let stiff = Inverse { stiffness: true, ..present.clone() };
        if !present.stiffness
            && let Some(s) = along.fit(&stiff)
            && along.worth(&solved, &s)
            && contenders
                .first()
                .is_none_or(|c| along.square(&s.residual, CHOOSE) < along.square(&c.1.residual, CHOOSE))
        {
            (present, solved) = (stiff, s);
            continue;
        }
        // A simpler effect that does as well, or one that comes first.
        let Some(best) = contenders.first() else { break };
        let least = along.square(&best.1.residual, CHOOSE) * (1.0 + ALTERNATIVE);
        let rank = |id: &str| catalogue.iter().position(|e| e.id() == id).unwrap_or(usize::MAX);
        let last = |i: &Inverse| i.terms.last().map_or("", |(e, _)| e.id());
        let next = contenders
            .iter()
            .filter(|c| along.square(&c.1.residual, CHOOSE) <= least)
            .min_by_key(|c| (c.0.terms.last().map_or(0, |(_, s)| s.len()), rank(last(&c.0))));
        let Some(next) = next.filter(|c| along.worth(&solved, &c.1)) else { break };
        (present, solved) = next.clone();
        // What a new effect has made idle goes.
        for t in (0..present.terms.len().saturating_sub(1)).rev() {
            let mut shorter = present.clone();
            shorter.terms.remove(t);
            if let Some(s) = along.fit(&shorter)
                && !along.worth(&s, &solved)
            {
                (present, solved) = (shorter, s);
            }
        }
        if present.stiffness {
            let free = Inverse { stiffness: false, ..present.clone() };
            if let Some(s) = along.fit(&free)
                && !along.worth(&s, &solved)
            {
                (present, solved) = (free, s);
            }
        }
        if present.terms.len() >= super::model::MOST_TERMS {
            break;
        }
    }
    let nominal_inverse = Inverse { stiffness: present.stiffness, terms: Vec::new() };
    let all = |inverse: &Inverse| solve(inverse, &motion, &|_| true);
    let (before, after) = (all(&nominal_inverse).ok_or_else(lost)?, all(&present).ok_or_else(lost)?);
    let proof = |inverse: &Inverse| solve(inverse, &motion, &|k| data.fold[k] as usize != SCORE);
    let (proof_before, proof_after) = (proof(&nominal_inverse), proof(&present));
    let effects = named(&along, &present, &after, &catalogue, &scale, nominal);
    let explained = 1.0 - square(&after.residual) / square(&before.residual).max(f64::MIN_POSITIVE);
    let locations = locations(&effects, explained, &motion);
    let own = predictions(recording, &motion, &before, &after);
    let other = held_out.map(|r| {
        let there = Motion::new(r, motion.cutoff_hz, Some(motion.slow()));
        predictions(r, &there, &before, &after)
    });
    let figures = |which: usize| -> Score {
        let pick = |p: &Predicted| if which == 0 { p.before[0].clone() } else { p.after[0].clone() };
        match held_out.zip(other.as_ref()) {
            Some((file, predicted)) => Score {
                train_rms: score::rms(recording, &recording.drives[0], &pick(&own), |_| true).unwrap_or(0.0),
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
    } else if coloured(&after.residual, &motion) {
        Verdict::PartlyExplained
    } else {
        Verdict::Explained
    };
    let mut unidentifiable = vec![
        "the controller: position and drive determine the mechanism, not what drove it".to_string(),
        "inertia and the drive's unit: everything is per inertia".to_string(),
    ];
    if !present.stiffness {
        unidentifiable.push("stiffness: none that this recording shows; it is left at zero".into());
    }
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
    };
    Ok(DynamicOutcome { diagnosis, plant: plant::to_file(&after.model, nominal), own, other })
}

fn square(residual: &[f64]) -> f64 {
    crate::rows::rms(residual).powi(2)
}

/// Whether a residual that has passed the filter still has most of its power far below the cut-off.
fn coloured(residual: &[f64], motion: &Motion) -> bool {
    let slow: Vec<f64> = (motion.runs.iter())
        .flat_map(|r| filter::low_pass(&residual[r.clone()], 0.2 * motion.cutoff_hz, motion.step_s))
        .collect();
    square(&slow) > 0.4 * square(residual)
}

fn predictions(recording: &DynamicRecording, motion: &Motion, before: &Solved, after: &Solved) -> Predicted {
    Predicted {
        t_s: recording.t_s.clone(),
        before: vec![predict(&before.model, motion)],
        after: vec![predict(&after.model, motion)],
    }
}

fn named(
    along: &Along,
    present: &Inverse,
    after: &Solved,
    catalogue: &[&'static dyn DynamicEffect],
    scale: &super::effects::Scale,
    nominal: &Plant,
) -> Vec<NamedEffect> {
    let Some(fitted) = along.fit(present) else { return Vec::new() };
    let mut said: Vec<NamedEffect> = Vec::new();
    for (t, term) in after.model.terms.iter().enumerate() {
        let mut shorter = present.clone();
        shorter.terms.remove(t);
        let Some(without) = along.fit(&shorter) else { continue };
        let gain = along.gain(&without, &fitted, FIT) + along.gain(&without, &fitted, CHOOSE);
        let rivals: Vec<&'static dyn DynamicEffect> =
            catalogue.iter().copied().filter(|e| term.effect.confused_with().contains(&e.id())).collect();
        let own = along.square(&fitted.residual, FIT) * (1.0 + ALTERNATIVE);
        let alternatives = along
            .contenders(&shorter, &rivals, scale)
            .iter()
            .filter(|c| along.square(&c.1.residual, FIT) <= own)
            .filter_map(|c| c.0.terms.last().map(|(e, _)| e.id().to_string()))
            .collect();
        let parameters = term
            .effect
            .readings(&term.parameters)
            .iter()
            .map(|r| {
                let variance: f64 =
                    r.gradient.iter().zip(&after.deviations[1 + t]).map(|(g, d)| (g * d).powi(2)).sum();
                let half = 1.96 * variance.sqrt();
                let unit = unit_of(r.unit, &nominal.position_unit, &nominal.drive_unit);
                Parameter {
                    name: r.name.into(),
                    value: r.value,
                    unit,
                    ci95: [r.value - half, r.value + half],
                }
            })
            .collect();
        let lost = square(&without.residual) - square(&fitted.residual);
        said.push(NamedEffect {
            id: term.effect.id().into(),
            title: term.effect.title().into(),
            p_value: p_value(gain, term.parameters.len()),
            share: lost.max(0.0),
            parameters,
            alternatives,
            runtime_correctable: term.effect.runtime_correctable(),
        });
    }
    said.sort_by(|a, b| b.share.total_cmp(&a.share));
    let total: f64 = said.iter().map(|e| e.share).sum::<f64>().max(f64::MIN_POSITIVE);
    said.iter_mut().for_each(|e| e.share /= total);
    said
}

fn locations(effects: &[NamedEffect], explained: f64, motion: &Motion) -> Vec<Location> {
    let mut out: Vec<Location> = Vec::new();
    for e in effects {
        let variable = effect(&e.id).map_or("velocity", |e| e.variable());
        if out.iter().any(|l| l.variable == variable) {
            continue;
        }
        let (from, to) = match variable {
            "position" | "history" => range(&motion.position),
            "drive" => range(&motion.drive),
            "frequency_hz" => (0.0, motion.cutoff_hz),
            _ => range(&motion.velocity),
        };
        let (share, p_value) = (e.share * explained, e.p_value);
        out.push(Location { variable: variable.into(), times: None, from, to, share, p_value });
    }
    out
}
