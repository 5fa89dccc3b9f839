//! Every effect beside a model: screened, the most promising fitted in full.

use numerics::parallel;

use super::{Augmented, Search, gain, last_id};
use crate::dynamic::data::{CHOOSE, FIT, FIT_ROWS};
use crate::dynamic::estimate::{Fitted, fit_in};
use crate::dynamic::screen::screen;
use crate::thresholds::dynamic::search::contenders::{
    BEHIND, LEAST_PROMISE, PLAINLY_BETTER, REFITTED, SHORT,
};

/// What a term beside one of several estimates promises on the rows that fit, as −2 log likelihood.
#[derive(Clone, Copy)]
struct Promise {
    base: usize,
    candidate: usize,
    gain: f64,
}

/// Those that promise most first.
fn sorted(mut all: Vec<Promise>) -> Vec<Promise> {
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

impl<M: Augmented> Search<'_, M> {
    /// Every effect beside one of several estimates of a model: the most promising in full, the best estimate of each, sorted
    /// by what they leave on the rows that choose.
    pub fn contenders(&self, bases: &[Fitted<M>]) -> Vec<Fitted<M>> {
        self.contenders_promising(bases, LEAST_PROMISE)
    }

    /// The same, of starts that promise more than `least`, in −2 log likelihood.
    pub fn contenders_promising(&self, bases: &[Fitted<M>], least: f64) -> Vec<Fitted<M>> {
        let beside = |base: &Fitted<M>| -> Vec<M::Term> {
            let effects = self.catalogue.iter().filter(|effect| !base.model.has(M::id(effect)));
            let terms = effects.flat_map(|effect| M::starts(effect, self.data));
            terms.filter(|term| base.model.with(term.clone()).is_some()).collect()
        };
        let candidates: Vec<Vec<M::Term>> = bases.iter().map(beside).collect();
        let mut models: Vec<(M, &[M::Start])> = self
            .promising(bases, &candidates, least)
            .into_iter()
            .filter_map(|p| {
                let base = &bases[p.base];
                Some((base.model.with(candidates[p.base][p.candidate].clone())?, &base.states[..]))
            })
            .collect();
        for (base, candidates) in bases.iter().zip(&candidates) {
            let further = M::further(self, base, candidates);
            models.extend(further.into_iter().map(|model| (model, &base.states[..])));
        }
        let tried = parallel::filter_map(&models, |(model, states)| model.begun(states, self.data));
        // What is far behind one with no more parameters after a few steps is not followed to its end.
        let size = |f: &Fitted<M>| f.model.packed().len();
        let behind =
            |f: &Fitted<M>| tried.iter().any(|g| size(g) <= size(f) && f.costs[FIT] > BEHIND * g.costs[FIT]);
        let mut followed: Vec<&Fitted<M>> = tried.iter().filter(|f| !behind(f)).collect();
        followed.sort_by(|a, b| a.costs[FIT].total_cmp(&b.costs[FIT]));
        followed.truncate(REFITTED);
        let mut fits = parallel::filter_map(&followed, |f| M::finished(self, (*f).clone()));
        fits.retain(|f| f.model.terms().last().is_some_and(|t| M::sound(t, self.data)));
        best_of_each(fits)
    }

    /// Every effect in the place of term `k` of an estimate, beside the estimate without it or begun from what the term is.
    pub fn in_place_of(&self, present: &Fitted<M>, k: usize, without: &Fitted<M>) -> Vec<Fitted<M>> {
        let replaced = M::replaced(self, present, k);
        let mut fits = parallel::filter_map(&replaced, |model| self.fit(model, &present.states));
        fits.retain(|f| f.model.terms().last().is_some_and(|t| M::sound(t, self.data)));
        fits.extend(self.contenders(std::slice::from_ref(without)));
        best_of_each(fits)
    }

    /// The starts that are worth an estimate in full: the best two of the effects that promise most, whitened and as they are.
    fn promising(&self, bases: &[Fitted<M>], candidates: &[Vec<M::Term>], least: f64) -> Vec<Promise> {
        let counts = |p: &Promise| p.gain > least;
        let id = |p: &Promise| M::id(M::effect(&candidates[p.base][p.candidate]));
        let (mut screened, mut plain): (Vec<Promise>, Vec<Promise>) = (Vec::new(), Vec::new());
        let mut whitened = false;
        for (number, base) in bases.iter().enumerate() {
            let whitening = self.whitening(base);
            whitened |= !whitening.is_empty();
            let gains = screen(base, &candidates[number], self.data, [&whitening, &[]]);
            let promise = |(candidate, gain)| Promise { base: number, candidate, gain };
            let [one, other] = gains.map(|gains| gains.into_iter().map(promise).collect::<Vec<_>>());
            screened.extend(one);
            plain.extend(other);
        }
        let screened = sorted(screened);
        let mut best: Vec<Promise> = Vec::new();
        for effect in &self.catalogue {
            best.extend(screened.iter().filter(|p| id(p) == M::id(effect)).take(2));
        }
        best.extend(self.unscreened(bases, candidates, &best, least));
        let mut ids: Vec<&str> = Vec::new();
        let mut best = sorted(best);
        best.retain(|p| {
            let new = !ids.contains(&id(p));
            if new {
                ids.push(id(p));
            }
            counts(p) && (ids.len() <= REFITTED || !new)
        });
        if whitened {
            // A residual that is nearly constant, or a few tones, is predicted by its own past, and with it what explains it: the
            // best starts by plain gain, one of each effect, are tried besides, unless the effect is tried from one that is nearly
            // as good. What is worth its parameters is decided later.
            let plain = sorted(plain);
            let plainly = |p: &Promise| {
                let same = |other: &&Promise| (other.base, other.candidate) == (p.base, p.candidate);
                plain.iter().find(same).map_or(0.0, |same| same.gain)
            };
            let mut ids: Vec<&str> = Vec::new();
            let most = best.len() + M::refitted_plainly();
            for p in plain.iter().filter(|p| counts(p)) {
                if ids.contains(&id(p)) || best.len() == most {
                    continue;
                }
                ids.push(id(p));
                let tried = best.iter().filter(|other| id(other) == id(p)).map(plainly).fold(0.0, f64::max);
                if p.gain > PLAINLY_BETTER * tried {
                    best.push(*p);
                }
            }
        }
        best
    }

    /// What has no amount (a lag, a limit): tried by a short estimate each.
    fn unscreened(
        &self,
        bases: &[Fitted<M>],
        candidates: &[Vec<M::Term>],
        screened: &[Promise],
        least: f64,
    ) -> Vec<Promise> {
        let id = |p: &Promise| M::id(M::effect(&candidates[p.base][p.candidate]));
        let helps = |other: &str| screened.iter().any(|p| id(p) == other && p.gain > least);
        let all: Vec<(usize, usize)> = candidates
            .iter()
            .enumerate()
            .flat_map(|(base, terms)| (0..terms.len()).map(move |candidate| (base, candidate)))
            .filter(|(base, candidate)| {
                let term = &candidates[*base][*candidate];
                let first = M::follows(M::effect(term));
                let known = |other| candidates[*base].iter().any(|t| M::id(M::effect(t)) == other);
                M::amounts(term) == 0 && first.is_none_or(|other| !known(other) || helps(other))
            })
            .collect();
        let one = |&(base, candidate): &(usize, usize)| {
            let present = &bases[base];
            let model = present.model.with(candidates[base][candidate].clone())?;
            let fitted = fit_in(SHORT, &model, &present.states, self.data, FIT_ROWS)?;
            Some(Promise { base, candidate, gain: gain(present, &fitted, FIT_ROWS) })
        };
        parallel::filter_map(&all, one)
    }
}

/// The best estimate of each effect that comes last, sorted by what they leave on the rows that choose.
pub fn best_of_each<M: Augmented>(fits: Vec<Fitted<M>>) -> Vec<Fitted<M>> {
    let mut of_effect: Vec<Fitted<M>> = Vec::new();
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
