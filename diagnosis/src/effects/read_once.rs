//! Declarations that many recordings have in common, read once: the units of a fleet have the same.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::Effect;

/// Effects by what their declarations depend on.
pub struct ReadOnce<K>(Mutex<BTreeMap<K, Arc<[Effect]>>>);

impl<K: Ord> ReadOnce<K> {
    /// Nothing read yet.
    pub const fn new() -> ReadOnce<K> {
        ReadOnce(Mutex::new(BTreeMap::new()))
    }

    /// The effects of `key`, made if it is asked for the first time.
    pub fn get(&self, key: K, made: impl FnOnce() -> Vec<Effect>) -> Arc<[Effect]> {
        // What a thread that failed left behind is whole: it is put in at once.
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(known.entry(key).or_insert_with(|| made().into()))
    }
}
