//! Which effects: forward, each by its linearised gain, then by an estimate in full, chosen on rows that did not fit it;
//! then backward.

use std::sync::Arc;

use motion::equations::MotionEffect;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::super::data::{ALL, CHOOSE, CHOOSE_ROWS, Data, FIT, FIT_ROWS};
use super::super::estimate::{Fitted, Simulated};
use super::super::noise::autoregression;
use super::super::screen::gained;
use super::super::search::{gain, worth};
use super::super::spectrum::fourier::coefficients;
use super::model::{Model, Term};
use super::start::{Nominal, estimated, relaxed, within};
use crate::thresholds::dynamic::equations::{BY_CHANCE, MOST_STARTS, OBSERVED, SIMPLER, STARTS};
use crate::thresholds::dynamic::estimate::PATIENCE;
use crate::thresholds::dynamic::gram::MOST_FREE;
use crate::thresholds::dynamic::model::MOST_TERMS;
use crate::thresholds::dynamic::remainder::PREDICTED;
use crate::thresholds::dynamic::search::LEAST_GAIN;
use crate::thresholds::dynamic::search::grow::{BEHIND, HEAT, REFITTED, SHORT};

/// The search.
pub struct Search<'a> {
    /// The rows.
    pub data: &'a Data<'a>,
    /// The effects that may be named, the user's own first.
    pub effects: Vec<Arc<MotionEffect>>,
    /// Number of terms, the first ones, that the plant's file holds and that are not in question.
    pub given: usize,
}

/// What a start of an effect beside an estimate promises on the rows that fit, whitened and as it is.
struct Promise<'b> {
    base: &'b Fitted<Model>,
    term: Term,
    whitened: f64,
    plain: f64,
}

/// An effect with all factors at zero, its other parameters spread over their ranges.
fn starts(effect: &Arc<MotionEffect>) -> Vec<Term> {
    let mut all = vec![Vec::new()];
    for parameter in &effect.parameters {
        let places = match parameter.range {
            None => vec![0.0],
            // What would be more starts than can be tried shares one place.
            Some(_) if all.len() * STARTS > MOST_STARTS => vec![within(parameter, 0.5)],
            Some(_) => (0..STARTS).map(|k| within(parameter, (k as f64 + 0.5) / STARTS as f64)).collect(),
        };
        let with = |values: Vec<f64>| places.iter().map(move |place| [values.clone(), vec![*place]].concat());
        all = all.into_iter().flat_map(|values| with(values).collect::<Vec<_>>()).collect();
    }
    all.into_iter().map(|values| Term { effect: effect.clone(), values, kept: false }).collect()
}

/// The id of the last term.
fn last_id(fitted: &Fitted<Model>) -> &str {
    fitted.model.terms.last().map_or("", |term| &term.effect.text.id)
}

impl<'a> Search<'a> {
    /// A model fitted to the rows that fit.
    pub fn fit(&self, model: &Model, states: &[Vec<f64>]) -> Option<Fitted<Model>> {
        estimated(PATIENCE, model, states, self.data, FIT_ROWS)
    }

    /// The effects beside a plant: begun in free run, and where structure is left from estimates under an observer as well.
    pub fn run(&self, nominal: &Nominal) -> Option<Fitted<Model>> {
        let mut present = self.fit(&nominal.free.model, &nominal.free.states)?;
        let mut observed = nominal.observed.clone();
        while present.model.terms.len() < MOST_TERMS {
            let mut contenders = self.contenders(std::slice::from_ref(&present));
            if self.structured(&present) {
                let under =
                    |f: &Fitted<Model>| self.fit(&Model { observed: OBSERVED, ..f.model.clone() }, &f.states);
                observed = observed.par_iter().filter_map(under).collect();
                contenders.extend(self.contenders(&observed));
            }
            let worthy = self.worthy(&present, best_of_each(contenders));
            let Some(next) = simplest(&worthy) else { break };
            let next = self.divided(next, &worthy).unwrap_or_else(|| next.clone());
            present = self.pruned(next);
            observed = vec![present.clone()];
        }
        Some(present)
    }

    /// Those of some contenders that are worth their parameters.
    fn worthy(&self, present: &Fitted<Model>, mut contenders: Vec<Fitted<Model>>) -> Vec<Fitted<Model>> {
        contenders.retain(|f| self.worth(present, f));
        contenders
    }

    /// Two simpler effects in the place of a richer one, where they do as well with fewer parameters.
    fn divided(&self, next: &Fitted<Model>, worthy: &[Fitted<Model>]) -> Option<Fitted<Model>> {
        let parameters = |f: &Fitted<Model>| f.model.terms.last().map_or(0, |term| term.values.len());
        let simple: Vec<&Fitted<Model>> =
            worthy.iter().filter(|f| parameters(f) + 1 < parameters(next)).collect();
        let pairs = simple
            .into_iter()
            .take(SIMPLER)
            .flat_map(|f| self.worthy(f, self.contenders(std::slice::from_ref(f))));
        pairs
            .filter(|pair| pair.model.packed().len() < next.model.packed().len())
            .filter(|pair| gain(pair, next, CHOOSE_ROWS) < 0.0)
            .min_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE]))
    }

    /// Whether the last effect of `after` is worth its parameters beside `before`: beside noise, or, where the residual
    /// before is nearly all structure that its own past predicts, beside a random residual of the same spectrum.
    fn worth(&self, before: &Fitted<Model>, after: &Fitted<Model>) -> bool {
        worth(self.data, before, after) || self.outweighs(before, after).unwrap_or(false)
    }

    /// Whether the gain is more than chance takes out of a residual with so few independent parts as the spectrum of the
    /// one before has; half of it must show on the rows that did not fit.
    fn outweighs(&self, before: &Fitted<Model>, after: &Fitted<Model>) -> Option<bool> {
        if !self.structured(before) {
            return Some(false);
        }
        let (mut power, mut square) = (0.0, 0.0);
        let residual = before.residual(self.data)?;
        for run in &self.data.runs {
            for line in coefficients(&residual[run.clone()]) {
                power += line.norm_sqr();
                square += line.norm_sqr().powi(2);
            }
        }
        // A line is a sine and a cosine.
        let parts = 2.0 * power * power / square;
        let parameters = after.model.packed().len().saturating_sub(before.model.packed().len()).max(1) as f64;
        let free = parts - parameters;
        let logarithm = |kind: usize| (before.costs[kind] / after.costs[kind]).ln();
        let ratio = logarithm(FIT).exp_m1() * free / parameters;
        let by_chance = FisherSnedecor::new(parameters, free).ok()?.sf(ratio.max(0.0));
        let least = BY_CHANCE / self.effects.len() as f64;
        Some(by_chance < least && logarithm(CHOOSE) > 0.5 * logarithm(FIT))
    }

    /// Whether what a model leaves is nearly all predicted by its own past.
    fn structured(&self, fitted: &Fitted<Model>) -> bool {
        let structured = |residual: Vec<f64>| {
            autoregression(&residual, &self.data.runs).innovation <= PREDICTED * fitted.rms(ALL)
        };
        fitted.residual(self.data).is_some_and(structured)
    }

    /// Every effect beside one of several estimates of a model: the most promising in full, sorted by what they leave on the
    /// rows that choose.
    pub fn contenders(&self, bases: &[Fitted<Model>]) -> Vec<Fitted<Model>> {
        let tried: Vec<Fitted<Model>> = self
            .promising(bases)
            .into_par_iter()
            .filter_map(|(base, term)| {
                estimated(HEAT, &base.model.with(term)?, &base.states, self.data, FIT_ROWS)
            })
            .collect();
        // What is far behind one with no more parameters after a few steps is not followed to its end.
        let size = |f: &Fitted<Model>| f.model.packed().len();
        let behind = |f: &Fitted<Model>| {
            tried.iter().any(|g| size(g) <= size(f) && f.costs[FIT] > BEHIND * g.costs[FIT])
        };
        let fits: Vec<Fitted<Model>> = tried
            .par_iter()
            .filter(|f| !behind(f))
            .filter_map(|f| {
                relaxed(estimated(PATIENCE, &f.model, &f.states, self.data, FIT_ROWS)?, self.data, FIT_ROWS)
            })
            .filter(|f| f.model.terms[self.given..].iter().all(sound))
            .collect();
        best_of_each(fits)
    }

    /// The starts that are worth an estimate in full: the best two of the effects that promise most.
    fn promising<'b>(&self, bases: &'b [Fitted<Model>]) -> Vec<(&'b Fitted<Model>, Term)> {
        let of_base = |base: &'b Fitted<Model>| -> Vec<Promise<'b>> {
            let residual = base.residual(self.data).unwrap_or_default();
            let whitening = autoregression(&residual, &self.data.runs).coefficients;
            let beside = self.effects.iter().filter(|effect| !base.model.has(&effect.text.id));
            let all: Vec<Term> = beside.flat_map(starts).collect();
            all.into_par_iter().filter_map(|term| self.promise(base, term, &whitening)).collect()
        };
        let promises: Vec<Promise> = bases.par_iter().flat_map(of_base).collect();
        let best = |by: fn(&Promise) -> f64, most: usize| {
            let mut sorted: Vec<&Promise> = promises.iter().filter(|p| by(p) > 0.3 * LEAST_GAIN).collect();
            sorted.sort_by(|a, b| by(b).total_cmp(&by(a)));
            let mut taken: Vec<&Promise> = Vec::new();
            let id = |p: &Promise| p.term.effect.text.id.clone();
            for promise in sorted {
                let own = taken.iter().filter(|p| id(p) == id(promise)).count();
                let mut ids: Vec<String> = taken.iter().map(|p| id(p)).collect();
                ids.dedup();
                ids.sort();
                ids.dedup();
                if own < 2 && (own > 0 || ids.len() < most) {
                    taken.push(promise);
                }
            }
            taken.into_iter().map(|p| (p.base, p.term.clone())).collect::<Vec<_>>()
        };
        let mut terms = best(|p| p.whitened, REFITTED);
        for term in best(|p| p.plain, REFITTED) {
            if terms.iter().all(|(_, t)| t.effect.text.id != term.1.effect.text.id) {
                terms.push(term);
            }
        }
        terms
    }

    /// What a start promises; none where it cannot be simulated.
    fn promise<'b>(&self, base: &'b Fitted<Model>, term: Term, whitening: &[f64]) -> Option<Promise<'b>> {
        let factors = term.effect.parameters.iter().filter(|p| p.range.is_none()).count();
        if factors == 0 {
            // What has no factor (a lag, a limit) is tried by a short estimate.
            let model = base.model.with(term)?;
            let fitted = estimated(SHORT, &model, &base.states, self.data, FIT_ROWS)?;
            let plain = gain(base, &fitted, FIT_ROWS);
            let term = fitted.model.terms.last()?.clone();
            return Some(Promise { base, term, whitened: plain, plain });
        }
        let free = base.model.packed().len();
        if free + factors > MOST_FREE {
            return None;
        }
        let model = base.model.with(Term { kept: true, ..term.clone() })?;
        let lanes: Vec<usize> = (0..free + factors).collect();
        let through = |filter: &[f64]| {
            let whole = model.normal(&base.states, self.data, filter).ok()?;
            Some(gained(&whole, free, &lanes).0)
        };
        let plain = through(&[])?;
        let whitened = if whitening.is_empty() { plain } else { through(whitening)? };
        Some(Promise { base, term, whitened, plain })
    }

    /// The model without the terms that a later one has made idle.
    fn pruned(&self, mut present: Fitted<Model>) -> Fitted<Model> {
        while present.model.terms.len() > 1 + self.given {
            let last = present.model.terms.len() - 1;
            let shorter: Vec<Fitted<Model>> = (self.given..last)
                .into_par_iter()
                .filter_map(|k| self.fit(&present.model.without(k)?, &present.states))
                .filter(|f| !self.worth(f, &present))
                .collect();
            match shorter.into_iter().min_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE])) {
                Some(f) => present = f,
                None => break,
            }
        }
        present
    }
}

/// The best estimate of each effect that comes last, sorted by what they leave on the rows that choose.
fn best_of_each(fits: Vec<Fitted<Model>>) -> Vec<Fitted<Model>> {
    let mut of_effect: Vec<Fitted<Model>> = Vec::new();
    for f in fits {
        match of_effect.iter_mut().find(|g| last_id(g) == last_id(&f)) {
            Some(g) if f.costs[FIT] < g.costs[FIT] => *g = f,
            Some(_) => {}
            None => of_effect.push(f),
        }
    }
    of_effect.sort_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE]));
    of_effect
}

/// Whether the parameters of a term are inside their ranges: at an end they say that it is something else.
fn sound(term: &Term) -> bool {
    term.effect.parameters.iter().zip(&term.values).all(|(parameter, value)| {
        value.is_finite() && parameter.range.is_none_or(|range| range.from < *value && *value < range.to)
    })
}

/// The best contender, or a simpler one that does as well.
fn simplest(contenders: &[Fitted<Model>]) -> Option<&Fitted<Model>> {
    let best = contenders.first()?;
    let free = |f: &Fitted<Model>| f.model.packed().len();
    let near = |f: &&Fitted<Model>| {
        let more = free(best).saturating_sub(free(f)) as f64;
        free(f) <= free(best) && gain(f, best, CHOOSE_ROWS) < 2.0 + 4.0 * more
    };
    contenders.iter().filter(near).min_by_key(|f| free(f))
}
