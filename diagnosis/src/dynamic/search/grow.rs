//! Growing the model of a second-order plant: which effect is taken, and what goes with it.

use fitter::plant::Hold;
use numerics::parallel;

use super::{Augmented, MOST_EXCHANGES, Search, worth};
use crate::dynamic::data::{ALL, Data, FIT, FIT_ROWS, Folds, HOLDS};
use crate::dynamic::effects::{CATALOGUE, DynamicEffect, Part, TRANSPORT_DELAY};
use crate::dynamic::estimate::{Fitted, fit, fit_in, fit_with_each_hold};
use crate::dynamic::model::{Model, Term};
use crate::thresholds::dynamic::estimate::PATIENCE;
use crate::thresholds::dynamic::model::MOST_TERMS;
use crate::thresholds::dynamic::search::contenders::{HEAT, REFITTED_PLAINLY};

impl Augmented for Model {
    type Effect = &'static DynamicEffect;
    type Term = Term;

    fn refitted_plainly() -> usize {
        REFITTED_PLAINLY
    }

    fn terms(&self) -> &[Term] {
        &self.terms
    }

    fn effect(term: &Term) -> &&'static DynamicEffect {
        &term.effect
    }

    fn id<'e>(effect: &'e &'static DynamicEffect) -> &'e str {
        effect.id
    }

    fn confused(effect: &&'static DynamicEffect, other: &&'static DynamicEffect) -> bool {
        effect.confused_with.contains(&other.id)
    }

    /// To first order a lag is a delay.
    fn follows(effect: &&'static DynamicEffect) -> Option<&'static str> {
        effect.confused_with.contains(&TRANSPORT_DELAY).then_some(TRANSPORT_DELAY)
    }

    fn starts(effect: &&'static DynamicEffect, data: &Data) -> Vec<Term> {
        (effect.starts)(&data.scale).into_iter().map(|start| Term::new(effect, start)).collect()
    }

    fn sound(term: &Term, data: &Data) -> bool {
        let finite = term.parameters.iter().all(|v| v.is_finite());
        finite && (term.effect.plausible)(&term.parameters, &data.scale)
    }

    fn amounts(term: &Term) -> usize {
        let amounts = || term.effect.parameters.iter().zip(&term.parameters).filter(|(p, _)| !p.shape);
        if amounts().all(|(_, v)| *v == 0.0) { amounts().count() } else { 0 }
    }

    fn states(term: &Term) -> usize {
        term.effect.states
    }

    fn probed(term: &Term) -> Term {
        let free = term.effect.parameters.iter().map(|p| !p.shape).collect();
        Term { free, probe: term.effect.part == Part::Force, ..term.clone() }
    }

    fn with(&self, term: Term) -> Option<Model> {
        Some(Model::with(self, term))
    }

    fn without(&self, k: usize) -> Option<Model> {
        Some(Model::without(self, k))
    }

    fn fitted(&self, states: &[[f64; 2]], data: &Data, folds: Folds) -> Option<Fitted<Model>> {
        fit(self, states, data, folds)
    }

    fn finished(search: &Search<Model>, fitted: Fitted<Model>) -> Option<Fitted<Model>> {
        fit_in(PATIENCE - HEAT, &fitted.model, &fitted.states, search.data, FIT_ROWS)
    }

    fn replaced(search: &Search<Model>, present: &Fitted<Model>, k: usize) -> Vec<Model> {
        let (term, mut models) = (&present.model.terms[k], Vec::new());
        for effect in search.catalogue.iter().filter(|e| !present.model.has(e.id)) {
            for start in (effect.starts_from)(term.effect.id, &term.parameters, &search.data.scale) {
                let model = present.model.without(k).with(Term::new(effect, start));
                // How late a drive is depends on how it runs between the samples.
                let holds = HOLDS.into_iter().filter(|hold| effect.is_late() || *hold == model.hold);
                models.extend(holds.map(|hold| Model { hold, ..model.clone() }));
            }
        }
        models
    }

    /// Beside nothing an effect that holds another as a special case is sought from zero, where its shape means nothing, and
    /// may run to where it is no physics: it is tried in the place of that.
    fn further(search: &Search<Model>, present: &Fitted<Model>, candidates: &[Term]) -> Vec<Model> {
        let terms = search.given..present.model.terms.len();
        terms.flat_map(|k| Model::replaced(search, present, k)).chain(late(present, candidates)).collect()
    }
}

/// Delays and lags beside the other ways of running between the samples. A held drive is half a sample late: where the
/// nominal plant took that for a delay of less, the true one beside it would be negative.
fn late(present: &Fitted, candidates: &[Term]) -> Vec<Model> {
    if present.model.terms.iter().any(|t| t.effect.is_late()) {
        return Vec::new();
    }
    let mut models = Vec::new();
    for hold in HOLDS.into_iter().filter(|h| *h != present.model.hold) {
        let mut ids = Vec::new();
        for candidate in candidates.iter().filter(|c| c.effect.is_late()) {
            if !ids.contains(&candidate.effect.id) {
                ids.push(candidate.effect.id);
                let mut model = present.model.with(candidate.clone());
                model.hold = hold;
                models.push(model);
            }
        }
    }
    models
}

impl<'a> Search<'a> {
    /// A search in the catalogue without the effects `skip`, beside a nominal plant of `given` terms.
    pub fn new(data: &'a Data<'a>, skip: &[String], given: usize) -> Search<'a> {
        let catalogue = CATALOGUE.iter().copied().filter(|e| skip.iter().all(|id| id != e.id)).collect();
        Search { data, catalogue, given }
    }

    /// The effects beside the nominal plant, on the rows that fit and choose.
    pub fn run(&self, nominal: &Fitted) -> Fitted {
        let Some(mut present) = self.fit(&nominal.model, &nominal.states) else { return nominal.clone() };
        for _ in 0..MOST_EXCHANGES {
            present = self.grown(present);
            match self.exchanged(&present) {
                Some(better) => present = better,
                None => break,
            }
        }
        present
    }

    /// The model fitted to all rows.
    pub fn complete(&self, chosen: &Fitted) -> Fitted {
        fit(&chosen.model, &chosen.states, self.data, ALL).unwrap_or_else(|| chosen.clone())
    }

    /// The model with the best way of running between the samples.
    pub(super) fn best_hold(&self, present: Fitted, folds: Folds) -> Fitted {
        let others: Vec<Hold> = HOLDS.into_iter().filter(|hold| *hold != present.model.hold).collect();
        let others = fit_with_each_hold(others, &present.model, &present.states, self.data, folds);
        others.into_iter().fold(present, |best, f| if f.cost(folds) < best.cost(folds) { f } else { best })
    }

    /// The model with every effect that is worth it, one after the other.
    fn grown(&self, mut present: Fitted) -> Fitted {
        while present.model.terms.len() < MOST_TERMS {
            let worthy = self.worthy(&present, self.contenders(std::slice::from_ref(&present)));
            let Some(next) = self.simplest(&worthy) else { break };
            let next = self.best_hold(next.clone(), FIT_ROWS);
            present = self.creeping(self.pruned(next));
        }
        present
    }

    /// The model with the creep of its dry friction freed, where the recording shows it.
    fn creeping(&self, present: Fitted) -> Fitted {
        let Some(k) = present.model.terms.iter().position(|t| t.effect.creep().is_some()) else {
            return present;
        };
        let Some(creep) = present.model.terms[k].effect.creep() else { return present };
        let freed = parallel::filter_map(&[3e-4, 3e-3, 3e-2], |part| {
            let mut model = present.model.clone();
            model.terms[k].parameters[creep] = part * self.data.scale.speed;
            model.terms[k].free[creep] = true;
            self.fit(&model, &present.states)
        });
        let best = freed.into_iter().min_by(|a, b| a.costs[FIT].total_cmp(&b.costs[FIT]));
        match best {
            Some(f) if worth(self.data, &present, &f) => f,
            _ => present,
        }
    }
}
