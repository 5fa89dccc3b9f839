//! Which effects help along a recorded motion: forward, each chosen on blocks of rows that did not fit it,
//! with what a later one has made idle left out again.

use numerics::{Basis, dot, parallel};

use super::inverse::{Solved, effect_columns, mechanism, model_columns, solve};
use super::motion::Motion;
use crate::dynamic::data::{CHOOSE, FIT};
use crate::dynamic::effects::{DynamicEffect, Parameter, Part, Scale};
use crate::dynamic::model::{Model, Term};
use crate::dynamic::search::Augmented;
use crate::thresholds::dynamic::feedback::search::{ALTERNATIVE, CONSISTENT, LEAST_PART, RESOLVED};
use crate::thresholds::dynamic::model::MOST_TERMS;
use crate::thresholds::dynamic::search::LEAST_GAIN;

/// Unit of a parameter that is a speed, and how many times the speed that counts as standing still it has to be.
const SPEED: &str = "p/s";
/// Unit of a parameter that is a frequency: it has to lie within the smoothing.
const FREQUENCY: &str = "Hz";

/// Whether a smoothed motion shows an effect with these parameters. What happens below the speed `slow` at which the
/// direction of motion is uncertain is not seen, nor is a resonance beyond the smoothing: its foot is taken for what
/// the smoothing leaves of a lag.
fn seen(effect: &DynamicEffect, parameters: &[f64], slow: f64, cutoff_hz: f64) -> bool {
    let one = |(j, (p, value)): (usize, (&Parameter, &f64))| match p.unit {
        SPEED => effect.creep() == Some(j) || *value > RESOLVED * slow,
        FREQUENCY => *value < cutoff_hz,
        _ => true,
    };
    effect.parameters.iter().zip(parameters).enumerate().all(one)
}

/// The search along one motion.
pub struct Along<'a> {
    pub motion: &'a Motion,
    /// Kind of every row.
    pub fold: &'a [u8],
    /// Independent readings per row.
    pub per_row: f64,
}

impl Along<'_> {
    /// The rows of one kind in which the mechanism moves.
    fn rows(&self, fold: usize) -> impl Iterator<Item = usize> + '_ {
        self.motion.rows().filter(move |k| self.fold[*k] as usize == fold)
    }

    /// Mean square of a residual on one kind of row.
    pub fn square(&self, residual: &[f64], fold: usize) -> f64 {
        let (sum, count) = self.rows(fold).fold((0.0, 0usize), |(s, n), k| (s + residual[k].powi(2), n + 1));
        sum / count.max(1) as f64
    }

    /// A model fitted on the rows that fit.
    pub fn fit(&self, shapes: &Model) -> Option<Solved> {
        solve(shapes, self.motion, &|k| self.fold[k] as usize == FIT)
    }

    /// −2 log likelihood gained on one kind of row.
    pub fn gain(&self, before: &Solved, after: &Solved, fold: usize) -> f64 {
        let rows = self.rows(fold).count() as f64 * self.per_row;
        let (a, b) = (self.square(&before.residual, fold), self.square(&after.residual, fold));
        rows * (a.max(f64::MIN_POSITIVE) / b.max(f64::MIN_POSITIVE)).ln()
    }

    /// How surely the effect helps on the blocks that did not fit it: the factor by which what it adds there fits best, in
    /// standard errors. It is 1 for an effect of the right size, and 0 for one that is not there. The error is by blocks
    /// (Liang & Zeger, Biometrika 73 (1986) 13–22): neighbouring rows of a residual are not independent, blocks nearly are.
    fn consistency(&self, before: &Solved, after: &Solved) -> f64 {
        // Of every block what the effect adds times what is left without it, and with it.
        let mut blocks: Vec<[f64; 2]> = Vec::new();
        let mut last = usize::MAX;
        for (k, fold) in self.fold.iter().enumerate() {
            let fold = usize::from(*fold);
            if fold != FIT {
                if last != fold {
                    blocks.push([0.0; 2]);
                }
                if let Some([without, with]) = blocks.last_mut().filter(|_| self.motion.moving[k]) {
                    let added = before.residual[k] - after.residual[k];
                    *without += added * before.residual[k];
                    *with += added * after.residual[k];
                }
            }
            last = fold;
        }
        let count = blocks.len() as f64;
        let (sum, squares) = blocks.iter().fold((0.0, 0.0), |(s, q), [a, b]| (s + a, q + b * b));
        let error = (squares * count / (count - 1.0).max(1.0)).sqrt();
        sum / error.max(f64::MIN_POSITIVE)
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
    fn with(&self, present: &Model, effect: &'static DynamicEffect, start: &[f64]) -> Option<Solved> {
        let fit = |shapes: &[f64]| self.fit(&present.with(Term::new(effect, shapes.to_vec())));
        let mut shapes = start.to_vec();
        let mut best = fit(&shapes)?;
        let shaped: Vec<usize> = (0..shapes.len())
            .filter(|j| effect.parameters[*j].shape && !effect.is_late() && *j < effect.kept)
            .collect();
        let mut width = 1.5;
        for _ in 0..if shaped.is_empty() { 0 } else { 6 } {
            for &j in &shaped {
                for factor in [width, 1.0f64 / width] {
                    let mut tried = shapes.clone();
                    match effect.parameters[j].place {
                        true => tried[j] += factor.ln() * tried[j + 1],
                        false => tried[j] *= factor,
                    }
                    if let Some(s) = fit(&tried)
                        && self.square(&s.residual, FIT) < self.square(&best.residual, FIT)
                    {
                        (shapes, best) = (tried, s);
                    }
                }
            }
            width = 1.0 + 0.6 * (width - 1.0);
        }
        Some(best)
    }

    /// The rows that fit of a column.
    fn fit_rows(&self, column: &[f64]) -> Vec<f64> {
        self.rows(FIT).map(|k| column[k]).collect()
    }

    /// What further columns explain of a residual, beside a basis of the rows that fit.
    fn explained(&self, basis: &Basis, residual: &[f64], columns: impl Iterator<Item = Vec<f64>>) -> f64 {
        let residual = self.fit_rows(residual);
        let mut all = basis.clone();
        columns.for_each(|c| _ = all.add(&self.fit_rows(&c)));
        (basis.rank()..all.rank()).map(|k| dot(&residual, all.columns.get(k)).powi(2)).sum()
    }

    /// All effects of a catalogue beside a model, the best first; equal ones in the catalogue's order.
    pub fn contenders(
        &self,
        present: &Solved,
        catalogue: &[&'static DynamicEffect],
        scale: &Scale,
    ) -> Vec<Solved> {
        let model = &present.model;
        let columns = model_columns(present, self.motion);
        let mut basis = Basis::new(self.rows(FIT).count());
        columns.iter().for_each(|(column, _)| _ = basis.add(&self.fit_rows(column)));
        let constant = |e: &DynamicEffect| matches!(e.part, Part::Drive | Part::SensorOffset);
        let has = |kind: &dyn Fn(&DynamicEffect) -> bool| model.terms.iter().any(|t| kind(t.effect));
        let one = |e: &&'static DynamicEffect| -> Option<Solved> {
            if model.has(e.id)
                || (e.is_late() && has(&DynamicEffect::is_late))
                || (constant(e) && has(&constant))
                || e.is_limit()
                || e.part == Part::DriveMemory
                || (e.part == Part::SensorOffset && !model.nominal_free[1])
            {
                return None;
            }
            let starts = [(e.starts)(scale), (e.starts_along)(scale)].concat();
            let start = if starts.len() == 1 || e.is_late() {
                &starts[0]
            } else {
                // The start whose columns explain most of the residual.
                let explained = |start: &Vec<f64>| -> f64 {
                    let columns = effect_columns(e, start, self.motion, model.nominal[2]);
                    self.explained(&basis, &present.residual, columns.into_iter().map(|(_, c)| c))
                };
                starts.iter().map(|s| (explained(s), s)).max_by(|a, b| a.0.total_cmp(&b.0))?.1
            };
            let solved = self.with(model, e, start)?;
            let parameters = &solved.model.terms.last()?.parameters;
            let seen = seen(e, parameters, self.motion.slow, self.motion.cutoff_hz);
            (seen && (e.plausible)(parameters, scale)).then_some(solved)
        };
        let mut found: Vec<Solved> = parallel::filter_map(catalogue, one);
        found.sort_by(|a, b| self.square(&a.residual, CHOOSE).total_cmp(&self.square(&b.residual, CHOOSE)));
        found
    }

    /// The effects beside a mechanism of inertia and damping alone; none where not even that can be fitted.
    pub fn search(&self, catalogue: &[&'static DynamicEffect], scale: &Scale) -> Option<Model> {
        let mut present = self.fit(&mechanism(false))?;
        let left = |solved: &Solved| self.square(&solved.residual, CHOOSE);
        let with_stiffness = |model: &Model, stiffness: bool| {
            self.fit(&Model { nominal_free: [true, stiffness, true], ..model.clone() })
        };
        loop {
            let contenders = self.contenders(&present, catalogue, scale);
            // A stiffness is nominal physics: it is taken where it helps more than any effect.
            if !present.model.nominal_free[1]
                && let Some(stiff) = with_stiffness(&present.model, true)
                && self.worth(&present, &stiff)
                && contenders.first().is_none_or(|c| left(&stiff) < left(c))
            {
                present = stiff;
                continue;
            }
            // A simpler effect that does as well, or one that comes first.
            let Some(best) = contenders.first() else { break };
            let least = left(best) * (1.0 + ALTERNATIVE);
            let rank = |id: &str| catalogue.iter().position(|e| e.id == id).unwrap_or(usize::MAX);
            let order = |c: &&Solved| c.model.terms.last().map(|t| (t.parameters.len(), rank(t.effect.id)));
            let next = contenders.iter().filter(|c| left(c) <= least).min_by_key(order);
            let Some(next) = next.filter(|c| self.worth(&present, c)) else { break };
            present = next.clone();
            // What a new effect has made idle goes.
            for t in (0..present.model.terms.len().saturating_sub(1)).rev() {
                let shorter = self.fit(&present.model.without(t));
                present = shorter.filter(|s| !self.worth(s, &present)).unwrap_or(present);
            }
            if present.model.nominal_free[1] {
                let free = with_stiffness(&present.model, false);
                present = free.filter(|s| !self.worth(s, &present)).unwrap_or(present);
            }
            if present.model.terms.len() >= MOST_TERMS {
                break;
            }
        }
        Some(present.model)
    }
}

#[cfg(test)]
mod tests {
    use super::{Along, seen};
    use crate::dynamic::data::{CHOOSE, FIT};
    use crate::dynamic::effects::effect;
    use crate::dynamic::feedback::inverse::{Solved, mechanism};
    use crate::dynamic::feedback::motion::Motion;
    use crate::thresholds::dynamic::feedback::search::CONSISTENT;

    #[test]
    fn an_effect_that_shows_in_few_blocks_is_as_sure_as_what_it_explains_there() {
        let (length, blocks) = (100, 16);
        let rows = length * blocks;
        let wave = |k: usize, step: usize| ((k * step) as f64 * 0.618).sin();
        let zero = vec![0.0; rows];
        let motion = Motion {
            step_s: 1e-3,
            runs: std::iter::once(0..rows).collect(),
            cutoff_hz: 100.0,
            position: zero.clone(),
            velocity: zero.clone(),
            acceleration: zero.clone(),
            drive: zero,
            slow: 0.0,
            moving: vec![true; rows],
        };
        let fold: Vec<u8> = (0..rows).map(|k| [FIT, CHOOSE][k / length % 2] as u8).collect();
        let along = Along { motion: &motion, fold: &fold, per_row: 0.2 };
        let solved = |residual| Solved { model: mechanism(false), residual };
        let left: Vec<f64> = (0..rows).map(|k| wave(k, 7)).collect();
        let beside = |added: &dyn Fn(usize) -> f64| {
            let before = left.iter().enumerate().map(|(k, left)| left + added(k)).collect();
            along.consistency(&solved(before), &solved(left.clone()))
        };
        // Twice in eight blocks, far above the noise.
        let rare = |k: usize| if matches!(k / length, 3 | 11) { 3.0 * wave(k, 5) } else { 0.0 };
        assert!(beside(&rare) > CONSISTENT, "{}", beside(&rare));
        // What takes off what happens to be left, in one block as much as it adds in the next.
        let chance = |k: usize| if k / length % 4 == 1 { -0.5 * left[k] } else { 0.5 * left[k] };
        assert!(beside(&chance) < 0.5 * CONSISTENT, "{}", beside(&chance));
    }

    #[test]
    fn what_the_smoothing_hides_is_not_seen() {
        let mode = effect("flexible_mode").expect("an effect");
        assert!(seen(mode, &[80.0, 0.1, 0.02], 5.0, 122.0));
        assert!(!seen(mode, &[800.0, 0.1, 0.02], 5.0, 122.0));
        let friction = effect("stribeck_friction").expect("an effect");
        // The last one is the speed of creep, whatever it is.
        assert!(seen(friction, &[1.0, 0.5, 20.0, 1e-6], 5.0, 122.0));
        assert!(!seen(friction, &[1.0, 0.5, 10.0, 1e-6], 5.0, 122.0));
    }
}
