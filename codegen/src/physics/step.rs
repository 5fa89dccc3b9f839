//! `step` terms of a further input: w from a threshold on. The comparison is one of words, which are exact, so that
//! it is right for every word.

use fitter::terms::Step;

use super::Result;
use super::builder::{Builder, Tracked, whole};
use super::further::Given;
use crate::exact::Interval;

/// Subtracts the term from the result.
pub(super) fn subtract(b: &mut Builder, step: &Step, weight: &Interval, given: &Given) -> Result {
    let in_words = (&Interval::from_f64(step.at) - &given.offset).div(&given.slope).mul_pow2(32);
    // A threshold less than 2⁻²⁰⁰ above a word is that word.
    let first = (&in_words.midpoint() - &Interval::pow2(-200)).ceil_to_i64();
    let (least, most) = whole(&given.word.range);
    let whole = (-weight.clone()).mul_pow2(b.sum.bits);
    match first {
        Some(first) if first > most => Ok(()),
        Some(first) if first > least => {
            let name = format!("step_{}", b.program.steps.len());
            let near = b.clamp(&name, &given.word, (first - 1, first), &Interval::zero(), "")?;
            let below = b.sub(&name, &near.exactly(), &Tracked::constant(&Interval::from_int(first)))?;
            let below = Tracked { range: Interval::from_int(-1).hull(&Interval::zero()), ..below };
            let wide = b.shift_left(&name, &below, 30, "-2^30 before the step, 0 from there on")?;
            b.add_constant(&whole)?;
            // −w·(1 + d), d = −1 before the step.
            b.add_scaled(&(-weight.clone()).mul_pow2(b.sum.bits + 2), &wide, "the step")
        }
        // From the box's lower end on.
        _ => b.add_constant(&whole),
    }
}
