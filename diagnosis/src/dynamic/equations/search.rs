//! Which effects of a plant in equations: begun in free run, and where that may be out of step with the recording, from
//! estimates under an observer as well.

use std::sync::Arc;

use motion::equations::MotionEffect;
use numerics::fourier::coefficients;
use numerics::parallel;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::super::accurate::estimated;
use super::super::data::{ALL, CHOOSE, CHOOSE_ROWS, Data, FIT, FIT_ROWS, Folds};
use super::super::estimate::{Fitted, Simulated, fit_in};
use super::super::noise::autoregression;
use super::super::search::contenders::best_of_each;
use super::super::search::{Augmented, gain, worth};
use super::model::{Model, Term};
use super::start::{Nominal, relaxed, within};
use crate::thresholds::dynamic::equations::{
    BY_CHANCE, FACTORS_FIRST, IN_STEP, MOST_STARTS, OBSERVED, PAIRED, SIMPLER, STARTS,
};
use crate::thresholds::dynamic::model::MOST_TERMS;
use crate::thresholds::dynamic::remainder::PREDICTED;
use crate::thresholds::dynamic::search::contenders::{HEAT, REFITTED};

/// The search, the user's own effects first.
pub type Search<'a> = super::super::search::Search<'a, Model>;

impl Augmented for Model {
    type Effect = Arc<MotionEffect>;
    type Term = Term;

    fn refitted_plainly() -> usize {
        REFITTED
    }

    fn terms(&self) -> &[Term] {
        &self.terms
    }

    fn effect(term: &Term) -> &Arc<MotionEffect> {
        &term.effect
    }

    fn id(effect: &Arc<MotionEffect>) -> &str {
        &effect.text.id
    }

    /// Either says so; in one of several places an id ends in the name of the place.
    fn confused(effect: &Arc<MotionEffect>, other: &Arc<MotionEffect>) -> bool {
        let says = |one: &MotionEffect, of: &MotionEffect| {
            one.text.confused_with.iter().any(|id| of.text.id.starts_with(id.as_str()))
        };
        says(effect, other) || says(other, effect)
    }

    /// All factors at zero, the other parameters spread over their ranges.
    fn starts(effect: &Arc<MotionEffect>, _: &Data) -> Vec<Term> {
        let mut all = vec![Vec::new()];
        for parameter in &effect.parameters {
            let places = match parameter.range {
                None => vec![0.0],
                // What would be more starts than can be tried shares one place.
                Some(_) if all.len() * STARTS > MOST_STARTS => vec![within(parameter, 0.5)],
                Some(_) => {
                    let count = effect.text.parameters.get(&parameter.name).and_then(|text| text.starts);
                    let count = count.unwrap_or(STARTS);
                    (0..count).map(|k| within(parameter, (k as f64 + 0.5) / count as f64)).collect()
                }
            };
            let with =
                |values: Vec<f64>| places.iter().map(move |place| [values.clone(), vec![*place]].concat());
            all = all.into_iter().flat_map(|values| with(values).collect::<Vec<_>>()).collect();
        }
        all.into_iter().map(|values| Term { effect: effect.clone(), values, kept: false }).collect()
    }

    /// Inside its ranges: at an end they say that it is something else.
    fn sound(term: &Term, _: &Data) -> bool {
        term.effect.parameters.iter().zip(&term.values).all(|(parameter, value)| {
            value.is_finite() && parameter.range.is_none_or(|range| range.from < *value && *value < range.to)
        })
    }

    fn amounts(term: &Term) -> usize {
        term.effect.parameters.iter().filter(|p| p.range.is_none()).count()
    }

    fn states(term: &Term) -> usize {
        term.effect.states.len()
    }

    fn probed(term: &Term) -> Term {
        Term { kept: true, ..term.clone() }
    }

    fn with(&self, term: Term) -> Option<Model> {
        self.with_terms(self.terms.iter().cloned().chain([term]).collect())
    }

    fn without(&self, k: usize) -> Option<Model> {
        let mut terms = self.terms.clone();
        terms.remove(k);
        self.with_terms(terms)
    }

    fn fitted(&self, states: &[Vec<f64>], data: &Data, folds: Folds) -> Option<Fitted<Model>> {
        estimated(self, states, data, folds)
    }

    /// The factors of a new term with other parameters first: beside factors of almost nothing a step would throw those
    /// anywhere.
    fn begun(&self, states: &[Vec<f64>], data: &Data) -> Option<Fitted<Model>> {
        let mixed = |term: &Term| (1..term.values.len()).contains(&Model::amounts(term));
        if !self.terms.last().is_some_and(mixed) {
            return fit_in(HEAT, self, states, data, FIT_ROWS);
        }
        let with = |model: &Model, kept: bool| {
            let mut model = model.clone();
            model.terms.iter_mut().next_back().into_iter().for_each(|term| term.kept = kept);
            model
        };
        let first = fit_in(FACTORS_FIRST, &with(self, true), states, data, FIT_ROWS)?;
        fit_in(HEAT, &with(&first.model, false), &first.states, data, FIT_ROWS)
    }

    fn finished(search: &Search, fitted: Fitted<Model>) -> Option<Fitted<Model>> {
        let fitted = search.fit(&fitted.model, &fitted.states)?;
        let sound =
            |f: &Fitted<Model>| f.model.terms[search.given..].iter().all(|t| Model::sound(t, search.data));
        relaxed(fitted, search.data, FIT_ROWS).filter(sound)
    }

    /// Beside noise, or, where the residual before is nearly all structure that its own past predicts, beside a random
    /// residual of the same spectrum.
    fn worth(search: &Search, before: &Fitted<Model>, after: &Fitted<Model>) -> bool {
        worth(search.data, before, after) || search.outweighs(before, after).unwrap_or(false)
    }
}

impl Search<'_> {
    /// The effects beside a plant.
    pub fn run(&self, nominal: &Nominal) -> Option<Fitted<Model>> {
        let mut present = self.fit(&nominal.free.model, &nominal.free.states)?;
        let mut observed = nominal.observed.clone();
        while present.model.terms.len() < MOST_TERMS {
            let mut contenders = self.contenders(std::slice::from_ref(&present));
            if self.structured(&present) && !self.keeps_step(&present) {
                let under =
                    |f: &Fitted<Model>| self.fit(&Model { observed: OBSERVED, ..f.model.clone() }, &f.states);
                observed = parallel::filter_map(&observed, under);
                contenders.extend(self.contenders(&observed));
            }
            let Some(next) = self.next(&present, &best_of_each(contenders)) else { break };
            present = self.pruned(next);
            observed = vec![present.clone()];
        }
        Some(present)
    }

    /// The model with the effect that is worth most, or, where none is worth its parameters alone, with two.
    fn next(&self, present: &Fitted<Model>, contenders: &[Fitted<Model>]) -> Option<Fitted<Model>> {
        let worthy = self.worthy(present, contenders.to_vec());
        match self.simplest(&worthy) {
            Some(next) => Some(self.divided(next, &worthy).unwrap_or_else(|| next.clone())),
            None => self.paired(present, contenders),
        }
    }

    /// Two effects that only together are worth their parameters: beside structure that neither explains alone, the one
    /// hides what the other would gain.
    fn paired(&self, present: &Fitted<Model>, contenders: &[Fitted<Model>]) -> Option<Fitted<Model>> {
        if !self.structured(present) {
            return None;
        }
        let beside = |f: &Fitted<Model>| self.contenders(std::slice::from_ref(f));
        let mut pairs = self.worthy(present, contenders.iter().take(PAIRED).flat_map(beside).collect());
        pairs.sort_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE]));
        self.simplest(&pairs).cloned()
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
        let effects = after.model.terms.len().saturating_sub(before.model.terms.len()).max(1);
        let least = BY_CHANCE / (self.catalogue.len() as f64).powi(effects as i32);
        Some(by_chance < least && logarithm(CHOOSE) > 0.5 * logarithm(FIT))
    }

    /// Whether a free run leaves so little of the motion that it is nowhere out of step: an observer leads to the same
    /// estimates then.
    fn keeps_step(&self, fitted: &Fitted<Model>) -> bool {
        fitted.part_left(self.data) <= IN_STEP.powi(2)
    }

    /// Whether what a model leaves is nearly all predicted by its own past.
    fn structured(&self, fitted: &Fitted<Model>) -> bool {
        let structured = |residual: Vec<f64>| {
            autoregression(&residual, &self.data.runs).innovation <= PREDICTED * fitted.rms(ALL)
        };
        fitted.residual(self.data).is_some_and(structured)
    }
}
