//! What the bound rests on, step by step: for every step that a term adds, the words that it can give and how far
//! they can be from exact, and the same of what it reads. A step may read more of an error than the step that it
//! comes from has: what an approximation is off comes between. [`crate::gappa`] makes another prover's script of it.

use std::collections::BTreeMap;

use super::builder::Tracked;
use crate::exact::Interval;
use crate::program::Operand;

/// A word as it was taken: all that it can be, and its largest distance from the exact number.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// See there.
    pub range: Interval,
    /// As a point, in words.
    pub error: Interval,
}

/// One step.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Its result.
    pub result: Taken,
    /// What it reads, in the order of its operands; empty where its result is known otherwise: a word of the state,
    /// or one that is limited.
    pub reads: Vec<Taken>,
}

/// All steps of all terms.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorAccount {
    /// By the step's number in the program.
    pub steps: BTreeMap<usize, Known>,
    /// The sum, all terms subtracted.
    pub sum: Operand,
    /// Its largest distance from exact by the terms, in words.
    pub error: Interval,
}

impl From<&Tracked> for Taken {
    fn from(word: &Tracked) -> Self {
        Taken { range: word.range.clone(), error: word.error.clone() }
    }
}

impl ErrorAccount {
    /// All words that the sum can be, where a term was added to it.
    pub fn range_of_sum(&self) -> Option<Interval> {
        match self.sum {
            Operand::Step(i) => self.steps.get(&i).map(|known| known.result.range.clone()),
            _ => None,
        }
    }
}
