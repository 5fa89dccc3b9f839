//! What stands beside a set of terms, kept: growing, exchanging and reshuffling come back to the same few sets
//! again and again, with and without the families that have no name.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

use numerics::{Basis, dot};

use super::{Found, Search, Term};
use crate::thresholds::search::beside::MOST_KEPT;

/// A set of terms, in whatever order: families and the bits of their shapes.
type Key = Vec<(usize, Vec<u64>)>;

/// The base grown by a set of terms, and every family's best candidate beside it.
pub(super) struct Beside {
    /// The whitened base and the terms' columns.
    pub basis: Basis,
    /// What the observations leave beside them.
    pub residual: Vec<f64>,
    /// The best candidate of every family, from the grid.
    pub found: Vec<Found>,
    refined: Mutex<BTreeMap<usize, Found>>,
}

impl Beside {
    /// The family's candidate after its shape was refined: by `refine`, where that was not done before.
    pub fn refined(&self, found: &Found, refine: impl FnOnce(Found) -> Found) -> Found {
        let known = |family| self.refined.lock().unwrap_or_else(PoisonError::into_inner).get(family).cloned();
        known(&found.term.family).unwrap_or_else(|| {
            let better = refine(found.clone());
            let mut all = self.refined.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(found.term.family, better.clone());
            better
        })
    }
}

/// The sets that were looked at last, and what each set explains.
#[derive(Default)]
pub(super) struct Kept {
    sets: Mutex<VecDeque<(Key, Arc<Beside>)>>,
    explained: Mutex<BTreeMap<Key, f64>>,
    backfitted: Mutex<BTreeMap<Key, Vec<Shape>>>,
}

/// The shape of a term and its rivals.
type Shape = (Vec<f64>, Arc<Vec<f64>>);

fn key(terms: &[Term]) -> Key {
    let bits = |shape: &[f64]| shape.iter().map(|v| v.to_bits()).collect();
    let mut key: Key = terms.iter().map(|t| (t.family, bits(&t.shape))).collect();
    key.sort();
    key
}

/// The terms in their order, with their rivals.
fn in_order(terms: &[Term]) -> Key {
    let bits = |t: &Term| t.shape.iter().chain(t.rivals.iter()).map(|v| v.to_bits()).collect();
    terms.iter().map(|t| (t.family, bits(t))).collect()
}

impl Search<'_> {
    /// The best candidate of every family beside the base alone, from the grid.
    pub fn survey(&self) -> Vec<Found> {
        self.beside(&[]).found.clone()
    }

    /// What stands beside the terms.
    pub(super) fn beside(&self, terms: &[Term]) -> Arc<Beside> {
        let key = key(terms);
        let sets = || self.kept.sets.lock().unwrap_or_else(PoisonError::into_inner);
        let known = sets().iter().find(|(k, _)| *k == key).map(|(_, beside)| Arc::clone(beside));
        if let Some(beside) = known {
            return beside;
        }
        // Not under the lock: a thread that waits for others within may be lent to work that asks for the same.
        let (basis, residual) = self.fit(terms);
        let found = self.survey_beside(&basis, &residual);
        let beside = Arc::new(Beside { basis, residual, found, refined: Mutex::default() });
        let mut kept = sets();
        if kept.len() == MOST_KEPT {
            kept.pop_front();
        }
        kept.push_back((key, Arc::clone(&beside)));
        beside
    }

    /// The shapes to which terms in this order, with these rivals, were refined before.
    pub(super) fn backfitted(&self, terms: &[Term]) -> Option<Vec<Shape>> {
        self.kept.backfitted.lock().unwrap_or_else(PoisonError::into_inner).get(&in_order(terms)).cloned()
    }

    /// Keeps them.
    pub(super) fn keep_backfitted(&self, before: &[Term], after: &[Term]) {
        let shapes = after.iter().map(|term| (term.shape.clone(), Arc::clone(&term.rivals))).collect();
        self.kept.backfitted.lock().unwrap_or_else(PoisonError::into_inner).insert(in_order(before), shapes);
    }

    /// What the terms explain together.
    pub fn explained(&self, terms: &[Term]) -> f64 {
        let key = key(terms);
        let known = self.kept.explained.lock().unwrap_or_else(PoisonError::into_inner).get(&key).copied();
        known.unwrap_or_else(|| {
            let (_, residual) = self.fit(terms);
            let explained = dot(&self.target, &self.target) - dot(&residual, &residual);
            self.kept.explained.lock().unwrap_or_else(PoisonError::into_inner).insert(key, explained);
            explained
        })
    }
}
