//! Growing a model: which effects are screened and fitted in full beside it, which of them is taken, and what that
//! makes idle.

use fitter::plant::Hold;
use rayon::prelude::*;

use super::{LEAST_GAIN, Search, gain, last_id, worth};
use crate::dynamic::data::{CHOOSE, CHOOSE_ROWS, FIT, FIT_ROWS, Folds, HOLDS};
use crate::dynamic::effects::{DynamicEffect, TRANSPORT_DELAY};
use crate::dynamic::estimate::{Fitted, fit_in, fit_in_ways};
use crate::dynamic::model::{Model, Term};
use crate::dynamic::screen::{Screened, linear, screen};
use crate::thresholds::dynamic::estimate::PATIENCE;
use crate::thresholds::dynamic::model::MOST_TERMS;
use crate::thresholds::dynamic::search::grow::{BEHIND, HEAT, REFITTED, REFITTED_PLAINLY, SHORT};

impl Search<'_> {
    /// Candidates that may stand beside a model.
    fn candidates(&self, present: &Fitted) -> Vec<Term> {
        let beside = self.catalogue.iter().filter(|e| !present.model.has(e.id));
        let terms = |e: &&'static DynamicEffect| {
            let e = *e;
            (e.starts)(&self.data.scale).into_iter().map(move |start| Term::new(e, start))
        };
        beside.flat_map(terms).collect()
    }

    /// Every effect beside a model, fitted on the rows that fit: the best few by screening in full, sorted
    /// by what they leave on the rows that choose.
    pub fn contenders(&self, present: &Fitted) -> Vec<Fitted> {
        let candidates = self.candidates(present);
        let best = self.promising(present, &candidates);
        let beside = |s: &Screened| present.model.with(candidates[s.candidate].clone());
        let mut models: Vec<Model> = best.iter().map(beside).collect();
        models.extend(self.late(present, &candidates));
        models.extend(self.widened(present));
        let tried: Vec<Fitted> = models
            .par_iter()
            .filter_map(|model| fit_in(HEAT, model, &present.states, self.data, FIT_ROWS))
            .collect();
        // What is far behind after a few steps is not followed to its end.
        let least = tried.iter().map(|f| f.costs[FIT]).fold(f64::INFINITY, f64::min);
        let fits: Vec<Fitted> = tried
            .into_par_iter()
            .filter_map(|f| match f.costs[FIT] < BEHIND * least {
                true => fit_in(PATIENCE - HEAT, &f.model, &f.states, self.data, FIT_ROWS),
                false => Some(f),
            })
            .filter(|f| f.model.terms.last().is_some_and(|term| self.sound(term)))
            .collect();
        let mut of_effect: Vec<Fitted> = Vec::new();
        for f in fits {
            let id = last_id(&f);
            match of_effect.iter_mut().find(|g| last_id(g) == id) {
                Some(g) if f.costs[FIT] < g.costs[FIT] => *g = f,
                Some(_) => {}
                None => of_effect.push(f),
            }
        }
        of_effect.sort_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE]));
        of_effect
    }

    /// The candidates that are worth a fit in full, by what they promise on the rows that fit.
    fn promising(&self, present: &Fitted, candidates: &[Term]) -> Vec<Screened> {
        let whitening = self.whitening(present);
        let [screened, mut plain] = screen(present, candidates, self.data, [&whitening, &[]]);
        let mut best: Vec<Screened> = Vec::new();
        for effect in &self.catalogue {
            let own = screened.iter().filter(|s| candidates[s.candidate].effect.id == effect.id);
            let mut own: Vec<&Screened> = own.collect();
            own.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            best.extend(own.into_iter().take(2).cloned());
        }
        // To first order a lag is a delay: it is tried only where a delay helps.
        let late = candidates.iter().all(|c| c.effect.id != TRANSPORT_DELAY)
            || best
                .iter()
                .any(|s| candidates[s.candidate].effect.id == TRANSPORT_DELAY && s.gain > 0.3 * LEAST_GAIN);
        // What has no amount (a lag, a limit) is tried by a short estimate.
        let short: Vec<Screened> = candidates
            .par_iter()
            .enumerate()
            .filter(|(_, c)| !linear(c) && (late || !c.effect.confused_with.contains(&TRANSPORT_DELAY)))
            .filter_map(|(k, c)| {
                let model = present.model.with(c.clone());
                let fitted = fit_in(SHORT, &model, &present.states, self.data, FIT_ROWS)?;
                Some(Screened { candidate: k, gain: gain(present, &fitted, FIT_ROWS) })
            })
            .collect();
        best.extend(short);
        best.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut ids: Vec<&str> = Vec::new();
        best.retain(|s| {
            let id = candidates[s.candidate].effect.id;
            let new = !ids.contains(&id);
            if new {
                ids.push(id);
            }
            s.gain > 0.3 * LEAST_GAIN && (ids.len() <= REFITTED || !new)
        });
        if !whitening.is_empty() {
            // A residual that is nearly constant, or a few tones, is predicted by its own past, and with it what
            // explains it: the best by plain gain are tried besides. What is worth its parameters is decided later.
            plain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            let mut ids: Vec<&str> = best.iter().map(|s| candidates[s.candidate].effect.id).collect();
            let most = best.len() + REFITTED_PLAINLY;
            for s in plain.into_iter().filter(|s| s.gain > 0.3 * LEAST_GAIN) {
                let id = candidates[s.candidate].effect.id;
                if !ids.contains(&id) && best.len() < most {
                    ids.push(id);
                    best.push(s);
                }
            }
        }
        best
    }

    /// Effects in the place of those that they hold as a special case. Beside nothing such an effect is sought from
    /// zero, where its shape means nothing, and may run to where it is no physics.
    fn widened(&self, present: &Fitted) -> Vec<Model> {
        let mut models = Vec::new();
        for (k, term) in present.model.terms.iter().enumerate().skip(self.given) {
            for effect in self.catalogue.iter().filter(|e| !present.model.has(e.id)) {
                let starts = (effect.starts_from)(term.effect.id, &term.parameters, &self.data.scale);
                let wider = |start| present.model.without(k).with(Term::new(effect, start));
                models.extend(starts.into_iter().map(wider));
            }
        }
        models
    }

    /// Delays and lags beside the other ways of running between the samples. A held drive is half a sample late:
    /// where the nominal plant took that for a delay of less, the true one beside it would be negative.
    fn late(&self, present: &Fitted, candidates: &[Term]) -> Vec<Model> {
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

    /// The model with the best way of running between the samples.
    pub(super) fn best_hold(&self, present: Fitted, folds: Folds) -> Fitted {
        let others: Vec<Hold> = HOLDS.into_iter().filter(|hold| *hold != present.model.hold).collect();
        let others = fit_in_ways(others, &present.model, &present.states, self.data, folds);
        others.into_iter().fold(present, |best, f| if f.cost(folds) < best.cost(folds) { f } else { best })
    }

    /// The model with every effect that is worth it, one after the other.
    pub(super) fn grown(&self, mut present: Fitted) -> Fitted {
        while present.model.terms.len() < MOST_TERMS {
            let worthy: Vec<Fitted> =
                self.contenders(&present).into_iter().filter(|f| worth(self.data, &present, f)).collect();
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
        let freed: Vec<Fitted> = [3e-4, 3e-3, 3e-2]
            .par_iter()
            .filter_map(|part| {
                let mut model = present.model.clone();
                model.terms[k].parameters[creep] = part * self.data.scale.speed;
                model.terms[k].free[creep] = true;
                self.fit(&model, &present.states)
            })
            .collect();
        let best = freed.into_iter().min_by(|a, b| a.costs[FIT].total_cmp(&b.costs[FIT]));
        match best {
            Some(f) if worth(self.data, &present, &f) => f,
            _ => present,
        }
    }

    /// The best contender, or a simpler one that does as well.
    fn simplest<'b>(&self, contenders: &'b [Fitted]) -> Option<&'b Fitted> {
        let best = contenders.first()?;
        let near = |f: &&Fitted| {
            let more = best.model.free().saturating_sub(f.model.free()) as f64;
            f.model.free() <= best.model.free() && gain(f, best, CHOOSE_ROWS) < 2.0 + 4.0 * more
        };
        contenders.iter().filter(near).min_by_key(|f| (f.model.free(), self.rank(last_id(f))))
    }

    fn rank(&self, id: &str) -> usize {
        self.catalogue.iter().position(|e| e.id == id).unwrap_or(usize::MAX)
    }

    /// The model without the terms that a later one has made idle.
    pub(super) fn pruned(&self, mut present: Fitted) -> Fitted {
        while present.model.terms.len() > 1 + self.given {
            let last = present.model.terms.len() - 1;
            let shorter: Vec<Fitted> = (self.given..last)
                .into_par_iter()
                .filter_map(|k| self.fit(&present.model.without(k), &present.states))
                .filter(|f| !worth(self.data, f, &present))
                .collect();
            match shorter.into_iter().min_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE])) {
                Some(f) => present = f,
                None => break,
            }
        }
        present
    }
}
