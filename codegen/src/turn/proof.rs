//! The proof by exhaustion: a program of one word is run on every word, exactly, and held against the enclosed
//! function.

use rayon::prelude::*;

use super::shape::Words;
use super::truth::Enclosed;
use crate::interpret::{Overflow, Word, interpret};
use crate::program::Program;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proof {
    /// The largest distance of a result from the exact one, in counts of the result, rounded up.
    pub bound: f64,
    /// The count where it is largest.
    pub worst: u32,
}

/// Runs every count of the turn; `exact` are their positions.
///
/// # Errors
/// [`Overflow`] where an operation leaves its type: then the program cannot be used.
pub fn prove(program: &Program, words: Words, exact: &[Enclosed]) -> Result<Proof, Overflow> {
    let distances: Vec<f64> = exact
        .par_iter()
        .enumerate()
        .map(|(count, exact)| {
            let out = interpret(program, &[Word::Int(count as i64)])?;
            Ok(distance(out.word.bits() as u32, exact, words))
        })
        .collect::<Result<_, Overflow>>()?;
    let mut proof = Proof { bound: 0.0, worst: 0 };
    for (count, distance) in (0..).zip(distances) {
        if distance > proof.bound {
            proof = Proof { bound: distance, worst: count };
        }
    }
    Ok(proof)
}

/// How far a result is from the exact one, round the turn, in counts of the result: rounded up.
pub fn distance(result: u32, exact: &Enclosed, words: Words) -> f64 {
    let turn = u128::from(words.result_counts());
    let off = (((u128::from(result) << 64) / turn) as u64).wrapping_sub(exact.word) as i64;
    // A word of 64 bits is rounded once, the sum once; the division by the turn loses less than a word.
    let lost = if words.whole() { 0.0 } else { 1.0 };
    let words_off = ((off.unsigned_abs() as f64).next_up() + (exact.radius + lost).next_up()).next_up();
    let counts = words.in_counts(words_off);
    if words.whole() { counts } else { counts.next_up().next_up() }
}
