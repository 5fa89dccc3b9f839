//! The set of terms: grown forward, with exchanges of one term and of two, and pruned.

use numerics::parallel;

use super::{Found, GRID_LOSS, Search, Term, handicap};
use crate::thresholds::search::refine::ROUGH;
use crate::thresholds::search::select::{
    EXCHANGE_MARGIN, FIRST_OF_PAIRS, MOST_FOR_PAIRS, MOST_GENERIC, MOST_TERMS, NEAR, REFINED,
};

impl Search<'_> {
    /// The best candidates beside the terms by merit, refined; `wanted` filters families.
    pub fn contenders(&self, terms: &[Term], wanted: impl Fn(usize) -> bool) -> Vec<Found> {
        self.contenders_refined(terms, wanted, REFINED, f64::NEG_INFINITY)
    }

    /// The same where only sets of at least this merit count: what cannot come near it is not refined.
    fn contenders_for(&self, merit: f64, terms: &[Term], wanted: impl Fn(usize) -> bool) -> Vec<Found> {
        self.contenders_refined(terms, wanted, REFINED, merit - self.merit(terms))
    }

    /// The same with `most` of them refined, of those that may gain `least` of merit once they are.
    pub fn contenders_refined(
        &self,
        terms: &[Term],
        wanted: impl Fn(usize) -> bool,
        most: usize,
        least: f64,
    ) -> Vec<Found> {
        let beside = self.beside(terms);
        let mut found: Vec<&Found> = beside
            .found
            .iter()
            .filter(|f| wanted(f.term.family) && self.allowed_beside(f.term.family, terms))
            .collect();
        found.sort_by(|a, b| self.gain(b).total_cmp(&self.gain(a)));
        let best = found.first().map_or(0.0, |f| self.gain(f));
        let promising: Vec<usize> = (0..found.len())
            .filter(|&k| {
                let shaped = self.effect(found[k].term.family).is_some() && !found[k].term.shape.is_empty();
                shaped && found[k].explained * GRID_LOSS > best.max(0.0)
            })
            .take(most)
            .filter(|k| found[*k].explained * GRID_LOSS - self.price(&found[*k].term) > least)
            .collect();
        let mut out: Vec<Found> = parallel::indices(0..found.len(), |k| {
            if promising.contains(&k) {
                beside.refined(found[k], |f| self.refine(f, &beside.basis, &beside.residual, ROUGH))
            } else {
                found[k].clone()
            }
        });
        out.sort_by(|a, b| self.gain(b).total_cmp(&self.gain(a)));
        out
    }

    /// Whether a family may stand beside these terms: an effect that cannot repeat only once.
    fn allowed_beside(&self, family: usize, terms: &[Term]) -> bool {
        let repeatable = self.effect(family).is_none_or(|e| self.catalogue[e].repeatable);
        if !self.takes_part(family) {
            return false;
        }
        let already = terms.iter().filter(|t| t.family == family).count();
        already < if repeatable { 2 } else { 1 }
    }

    /// What a candidate adds to the merit.
    pub fn gain(&self, found: &Found) -> f64 {
        found.explained - self.price(&found.term)
    }

    /// Searches from `start` until nothing significant is left and no exchange improves the merit: once with
    /// the catalogue before anything without a name, and, where one name does not account for everything,
    /// once with all together, because a curve that is taken first may hide two effects, and two effects may
    /// imitate what has no name. The better set is kept.
    pub fn run(&self, start: Vec<Term>) -> Vec<Term> {
        let named = self.grow(start.clone(), true);
        let named = self.grow(named, false);
        if named.len() <= 1 && !named.iter().any(|t| self.is_generic(t.family)) {
            return named;
        }
        let free = self.grow(start, false);
        if self.merit(&free) > self.merit(&named) + EXCHANGE_MARGIN { free } else { named }
    }

    /// Exchanges two terms at once for two of the catalogue: a time constant that was refined beside the wrong
    /// partner makes the right one look worse than it is, and neither gives way alone.
    pub fn reshuffle(&self, terms: Vec<Term>) -> Vec<Term> {
        let mut terms = terms;
        for _ in 0..2 {
            if terms.len() < 2 || terms.len() > MOST_FOR_PAIRS + 1 {
                return terms;
            }
            let merit = self.merit(&terms);
            let mut better: Option<(f64, Vec<Term>)> = None;
            for k in 0..terms.len() {
                for j in k + 1..terms.len() {
                    let mut rest = terms.clone();
                    rest.remove(j);
                    rest.remove(k);
                    for set in self.pairs_beside(&rest, merit - NEAR) {
                        if self.merit(&set) < merit - NEAR {
                            continue;
                        }
                        let mut set = set;
                        self.backfit(&mut set);
                        let m = self.merit(&set);
                        if m > merit + EXCHANGE_MARGIN && better.as_ref().is_none_or(|b| m > b.0) {
                            better = Some((m, set));
                        }
                    }
                }
            }
            match better {
                Some((_, set)) => terms = set,
                None => return terms,
            }
        }
        terms
    }

    /// Promising pairs of catalogued effects beside the terms, with them; sets below this merit do not count.
    fn pairs_beside(&self, terms: &[Term], least: f64) -> Vec<Vec<Term>> {
        let named = |f: usize| self.effect(f).is_some();
        let mut out = Vec::new();
        for first in self.contenders(terms, named).into_iter().take(FIRST_OF_PAIRS) {
            let mut with = terms.to_vec();
            with.push(first.term);
            for second in self.contenders_for(least, &with, named).into_iter().take(2) {
                let mut pair = with.clone();
                pair.push(second.term);
                out.push(pair);
            }
        }
        out
    }

    /// Adds and exchanges terms, only catalogued ones where `named_only`.
    fn grow(&self, start: Vec<Term>, named_only: bool) -> Vec<Term> {
        let mut terms = start;
        self.backfit(&mut terms);
        self.exchange(&mut terms, named_only);
        for _ in 0..2 * MOST_TERMS {
            let unexplained = terms.iter().filter(|t| self.is_generic(t.family)).count();
            if terms.len() >= MOST_TERMS || unexplained >= MOST_GENERIC {
                break;
            }
            let contenders = self.contenders(&terms, |f| !named_only || !self.is_generic(f));
            let Some(next) = contenders.into_iter().find(|f| self.significant(f)) else { break };
            terms.push(next.term);
            self.backfit(&mut terms);
            self.exchange(&mut terms, named_only);
        }
        self.prune(&mut terms);
        terms
    }

    /// Drops terms that no longer pay.
    fn prune(&self, terms: &mut Vec<Term>) {
        loop {
            let whole = self.explained(terms);
            let weakest = (0..terms.len())
                .map(|k| {
                    let mut without = terms.clone();
                    let term = without.remove(k);
                    let own =
                        self.calibration.price(term.family, self.shares[term.family], term.columns.len());
                    (k, whole - self.explained(&without) - own)
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((k, surplus)) if surplus < 0.0 => {
                    terms.remove(k);
                }
                _ => return,
            }
        }
    }

    /// Exchanges terms for better ones, drops those that do not pay, and tries two catalogued effects in
    /// place of a generic one.
    fn exchange(&self, terms: &mut Vec<Term>, named_only: bool) {
        let mut merit = self.merit(terms);
        for _ in 0..4 {
            let singly = parallel::indices(0..terms.len(), |k| self.without(terms, k, merit, named_only));
            // One explanation in the place of two.
            let few = if terms.len() <= MOST_FOR_PAIRS { terms.len() } else { 0 };
            let pairs: Vec<_> = (0..few).flat_map(|k| (k + 1..few).map(move |j| (k, j))).collect();
            let for_pairs = parallel::filter_map(&pairs, |(k, j)| {
                let mut with: Vec<Term> = terms.clone();
                with.remove(*j);
                with.remove(*k);
                let wanted = |f: usize| !named_only || !self.is_generic(f);
                let found = self.contenders_for(merit + EXCHANGE_MARGIN, &with, wanted);
                with.push(found.into_iter().next()?.term);
                Some((self.merit(&with), with))
            });
            let sets = singly.into_iter().flatten().chain(for_pairs);
            // Of equal sets the first.
            let better = sets.rev().max_by(|a, b| a.0.total_cmp(&b.0));
            match better {
                Some((m, candidate)) if m > merit + EXCHANGE_MARGIN => {
                    *terms = candidate;
                    merit = m;
                }
                _ => return,
            }
        }
    }

    /// Sets that may take the place of `terms`, of this merit, without its term `k`, with their merits: fewer
    /// terms, another one for it, or two catalogued ones.
    fn without(&self, terms: &[Term], k: usize, merit: f64, named_only: bool) -> Vec<(f64, Vec<Term>)> {
        let mut sets = Vec::new();
        let mut without = terms.to_vec();
        let removed = without.remove(k);
        if terms.len() > 1 {
            // The handicap is for comparisons with other explanations, not with nothing.
            let lost = if self.is_generic(removed.family) { handicap(&removed) } else { 0.0 };
            sets.push((self.merit(&without) - lost, without.clone()));
        }
        // Refining all terms together brings little: only a near contender is worth it.
        let consider = |mut with: Vec<Term>, sets: &mut Vec<(f64, Vec<Term>)>| {
            if self.merit(&with) > merit - NEAR {
                self.backfit(&mut with);
                sets.push((self.merit(&with), with));
            }
        };
        let wanted = |f: usize| f != removed.family && (!named_only || !self.is_generic(f));
        // Of two effects in its place each may explain little.
        let for_two = self.is_generic(removed.family) || terms.len() == 1;
        let least = if for_two { f64::NEG_INFINITY } else { merit - NEAR };
        let others = self.contenders_for(least, &without, wanted);
        for other in others.iter().take(2) {
            let mut with = without.clone();
            with.push(other.term.clone());
            consider(with, &mut sets);
        }
        if for_two {
            let catalogued = others.iter().filter(|o| self.effect(o.term.family).is_some());
            for first in catalogued.take(3) {
                let mut with = without.clone();
                with.push(first.term.clone());
                let second = self.contenders_for(merit - NEAR, &with, |f| self.effect(f).is_some());
                if let Some(second) = second.into_iter().next() {
                    with.push(second.term);
                    consider(with, &mut sets);
                }
            }
        }
        sets
    }
}
