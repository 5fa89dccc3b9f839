//! The last sum of the routine, from which the terms are subtracted.

use super::builder::{Builder, Tracked};
use super::{PhysicsError, Result};
use crate::exact::Interval;

/// A word of 2^−bits of the result's unit.
pub(super) struct Sum {
    pub word: Tracked,
    pub bits: i64,
    /// What an approximation may be off, in words.
    pub tolerance: Interval,
    /// A part this small need not be evaluated.
    pub negligible: Interval,
    /// How much of an error before the terms is left after them, 1 where they only add.
    pub gain: Interval,
}

impl Builder {
    /// Adds a·factor·2⁻³² to the sum.
    pub fn add_scaled(&mut self, factor: &Interval, a: &Tracked, note: &str) -> Result {
        let (factor, shift) = fitted(factor, 30)?;
        self.sum.word = self.mul_add("y", (&factor, a), shift, &self.sum.word.clone(), note)?;
        Ok(())
    }

    /// Adds a constant of the sum's words.
    pub fn add_constant(&mut self, constant: &Interval) -> Result {
        if constant.magnitude().certainly_le(&self.sum.negligible) {
            self.add_error(&constant.magnitude());
        } else {
            self.sum.word = self.add("y", &self.sum.word.clone(), &Tracked::constant(constant), "")?;
        }
        Ok(())
    }

    /// Leaves a part out that is at most `largest` in the result's unit, of either sign, where that is next to nothing.
    pub fn leaves_out(&mut self, largest: &Interval) -> bool {
        let words = largest.magnitude().mul_pow2(self.sum.bits);
        let negligible = words.certainly_le(&self.sum.negligible);
        if negligible {
            self.add_error(&words);
        }
        negligible
    }

    /// Notes that the sum may be off by so many words more.
    pub fn add_error(&mut self, words: &Interval) {
        self.sum.word.error = (&self.sum.word.error + words).upper();
    }
}

/// A factor as a word and the shift to the left that follows its product, the smallest below `shifts` that fits.
pub(super) fn fitted(factor: &Interval, shifts: i64) -> Result<(Tracked, u32)> {
    let largest = Interval::from_int(i32::MAX.into());
    let fits = |shift: &i64| factor.mul_pow2(-shift).magnitude().certainly_le(&largest);
    let shift = (0..shifts).find(fits).ok_or(PhysicsError::TooLarge)?;
    Ok((Tracked::constant(&factor.mul_pow2(-shift)), shift as u32))
}
