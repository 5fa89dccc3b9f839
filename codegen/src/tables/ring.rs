//! What is wanted of a table: the correction of every count of a turn, and of any place between.

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;
use rayon::prelude::*;

use super::single::Fused;
use super::{Asked, TableError};
use crate::budget;
use crate::turn::shape::Words;
use crate::turn::truth::Truth;
use crate::turn::wraps::Wraps;
use crate::turn::{self, TurnError};

/// 2⁻⁶⁴: a word of the turn in turns.
const WORD: f64 = 1.0 / 18_446_744_073_709_551_616.0;

/// The corrections, in turns: what is added to a reading, but for the zero of the mount.
pub struct Ring {
    truth: Truth,
    /// Counts of the turn.
    pub counts: u32,
    /// The correction of every count.
    pub wanted: Vec<f64>,
    /// How far any of them may be from the exact one.
    pub radius: f64,
    /// The sensor's unit in a turn.
    pub revolution: f64,
    /// By how much a reading is above the reference once it is corrected, in turns.
    pub zero: f64,
    /// The highest harmonic, at least 1.
    pub harmonics: u32,
    /// What a correction of the position alone leaves out, with its size.
    pub left_out: Vec<String>,
    wraps: Wraps,
}

impl Ring {
    /// Of coefficients of a whole turn, read in as many counts as are asked for, or in as many as the firmware always has.
    ///
    /// # Errors
    /// [`TableError`] where they are not, or the turn has no known number of counts.
    pub fn of(
        firmware: &'static str,
        coefficients: &Coefficients,
        asked: &Asked<'_>,
        always: Option<u32>,
    ) -> Result<Ring, TableError> {
        if !coefficients.whole_turn() {
            return Err(TableError::NotATurn { firmware });
        }
        let words = match always {
            Some(counts) => Words { counts, finer: 0 },
            // The bound holds for all counts: they are not guessed from the noise.
            None if asked.options.encoder.assumes(coefficients) => {
                let unit = coefficients.sensor.error_unit().to_string();
                return Err(TurnError::UnknownBits { unit }.into());
            }
            None => asked.options.encoder.words(coefficients)?,
        };
        let truth = Truth::new(coefficients)?;
        let revolution = coefficients.turn.as_ref().map_or(1.0, |turn| turn.revolution);
        let wraps = Wraps::of(coefficients)?;
        let zero = wraps.zero / revolution;
        let harmonics = wraps.waves.iter().map(|wave| wave.0).max().unwrap_or(1);
        let left_out = turn::describe::left_out(coefficients, &wraps);
        let mut ring = Ring {
            truth,
            counts: words.counts,
            wanted: Vec::new(),
            radius: 0.0,
            revolution,
            zero,
            harmonics,
            left_out,
            wraps,
        };
        (ring.wanted, ring.radius) = ring.all(words);
        Ok(ring)
    }

    fn all(&self, words: Words) -> (Vec<f64>, f64) {
        let gain = if words.whole() { 0.0 } else { self.truth.gain() };
        let mut largest = 0.0f64;
        let each = (0..words.counts).map(|count| {
            let (moved, radius) = self.moved(words.reading(count));
            largest = largest.max(radius + gain);
            moved * WORD
        });
        let wanted: Vec<f64> = each.collect();
        // A word of 63 bits is rounded to 53: less than 2⁻⁵⁴ of half a turn.
        (wanted, largest * WORD + 2f64.powi(-54))
    }

    /// The correction of a reading in words, but for the zero, and how far it may be off.
    fn moved(&self, reading: u64) -> (f64, f64) {
        let found = self.truth.at(reading);
        let moved = found.word.wrapping_sub(reading).wrapping_add(self.truth.zero()) as i64;
        (moved as f64, found.radius)
    }

    /// The uncertainty budget of a table that is proved within `bound`.
    pub fn budget(&self, coefficients: &Coefficients, bound: f64) -> Option<Budget> {
        let step = self.revolution / f64::from(self.counts);
        budget::of_ring(coefficients, &self.wraps, bound, step)
    }

    /// The correction at a place in turns, below 1.
    pub fn at(&self, turns: f64) -> f64 {
        self.moved((turns / WORD) as u64).0 * WORD
    }

    /// The least and the most that is wanted.
    pub fn ends(&self) -> (f64, f64) {
        let least = self.wanted.iter().copied().fold(f64::INFINITY, f64::min);
        (least, self.wanted.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }

    /// The largest distance of the firmware's result, in turns, of all counts and all ways to compile it.
    pub fn worst(&self, constant: f64, result: impl Fn(u32, Fused) -> f64 + Sync) -> f64 {
        let of = |count: u32| {
            let results = Fused::ALL.iter().map(|fused| result(count, *fused));
            results.map(|result| self.distance(count, result, constant)).fold(0.0, f64::max)
        };
        (0..self.counts).into_par_iter().map(of).reduce(|| 0.0, f64::max)
    }

    /// How far a result is from what is wanted of a count, both in turns and round the turn; `constant` is added to all
    /// that is wanted. Rounded up.
    fn distance(&self, count: u32, result: f64, constant: f64) -> f64 {
        let place = f64::from(count) / f64::from(self.counts);
        let off = result - place - self.wanted[count as usize] - constant;
        // Five roundings of numbers below 2.
        (off - off.round()).abs() + self.radius + 10.0 * f64::EPSILON
    }
}
