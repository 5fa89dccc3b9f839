//! Work on several threads, results in the order of the items: the same for any number of threads.
//!
//! The threads are rayon's. Its generic iterators are compiled here once, behind a function pointer, instead of at every
//! call: an item of work takes microseconds at least, the pointer a nanosecond.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// `f` of every item.
pub fn map<'a, T: Sync, R: Send>(items: &'a [T], f: impl Fn(&'a T) -> R + Sync) -> Vec<R> {
    indices(0..items.len(), |k| f(&items[k]))
}

/// `f` of every item, where it gives something.
pub fn filter_map<'a, T: Sync, R: Send>(items: &'a [T], f: impl Fn(&'a T) -> Option<R> + Sync) -> Vec<R> {
    map(items, f).into_iter().flatten().collect()
}

/// `f` of every index.
pub fn indices<R: Send>(range: Range<usize>, f: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let results: Vec<Mutex<Option<R>>> = range.clone().map(|_| Mutex::new(None)).collect();
    each(results.len(), &|k| {
        let result = f(range.start + k);
        *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    results.into_iter().filter_map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// Both at the same time.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    let (mut first, mut second) = ((Some(a), None), (Some(b), None));
    both(&mut || first.1 = first.0.take().map(|a| a()), &mut || second.1 = second.0.take().map(|b| b()));
    match (first.1, second.1) {
        (Some(a), Some(b)) => (a, b),
        _ => unreachable!("both have run"),
    }
}

fn each(count: usize, f: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(f);
}

fn both(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}
