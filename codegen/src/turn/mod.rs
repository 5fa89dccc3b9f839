//! Sensors that turn round and round: a routine *counts in → corrected counts out*, exact at the wrap.
//!
//! An encoder has so few counts that nothing needs to be estimated: `truth` encloses the exact corrected position
//! of every count, [`shape`] lists the ways to write the correction as a [`crate::program`], `fit` finds their
//! coefficients, and `proof` runs the program on every count. [`choose`] takes the cheapest that meets the bound,
//! and `describe` says what certificate and heads tell of it.

pub mod choose;
pub(crate) mod describe;
mod fit;
#[cfg(test)]
#[path = "../../tests/all/turn/encoder.rs"]
pub(crate) mod fixtures;
mod phase;
mod proof;
pub mod shape;
pub(crate) mod truth;
pub mod verify;
pub(crate) mod wraps;

use fitter::coefficients::Coefficients;
use fitter::error_model::Sensor;

use crate::cost::Core;

use shape::Words;

/// What is wanted of the routine of an encoder.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Encoder {
    /// Bits of its word, 10 to 18, every word being a count; none: see `counts`.
    pub bits: Option<u32>,
    /// Counts of its turn, where they are no power of two; none, and no `bits`: the sensor's unit is counts, and its
    /// revolution says so.
    pub counts: Option<u32>,
    /// Bits of the corrected word, as many as the encoder's or up to 6 more, each of which makes it twice as fine; none:
    /// as many.
    pub output_bits: Option<u32>,
    /// The core whose instructions count; none: Cortex-M4F.
    pub core: Option<Core>,
    /// Bytes of flash, code and table together; none: [`USUAL_FLASH_BYTES`].
    pub flash_bytes: Option<usize>,
}

/// Flash that a routine may take unless more, or less, is granted. A table of every count of a 14-bit encoder would
/// take 16 KiB and save a few instructions.
pub const USUAL_FLASH_BYTES: usize = 2048;
/// What it may take where no routine of the usual size reaches the bound and the user set no limit.
pub const MOST_FLASH_BYTES: usize = 65_536;

/// The bound unless one is named, in counts of the result: half a count is lost by rounding, whatever is done.
pub const USUAL_BOUND: f64 = 0.55;

/// Bits that an encoder's word may have.
pub const BITS: std::ops::RangeInclusive<u32> = 10..=18;

/// Counts that a turn may have, where they are no power of two.
pub const FEWEST_COUNTS: u32 = 256;
/// See [`FEWEST_COUNTS`].
pub const MOST_COUNTS: u32 = 1 << *BITS.end();

fitter::errors! {
    /// Why there is no routine for an encoder.
    #[derive(Debug, Clone, PartialEq)]
    pub enum TurnError {
        NotATurn => says("these coefficients are not of a whole turn");
        UnknownBits { unit: String } =>
            says("the sensor's unit is {unit}")
            mend("say how many bits the encoder's word has, or how many counts its turn has")
            by(bits = 14) by(counts = 4000);
        Bits { bits: u32 } =>
            says("an encoder of {bits} bits") mend("give {} to {}", BITS.start(), BITS.end()) by(bits);
        Counts { counts: f64 } =>
            says("a turn of {counts} counts")
            mend("give whole counts from {FEWEST_COUNTS} to {MOST_COUNTS}") by(counts);
        Contradiction { counts: u64, value: &'static str, revolution: f64 } =>
            says("{counts} counts to the turn are asked for, and the recording's revolution is {revolution}")
            mend("leave them out") by_name(value);
        BitsAndCounts =>
            says("both bits and counts say how many counts a turn has") mend("give one of them") by(bits) by(counts);
        OutputBits { input: u32, output: u32 } =>
            says("a corrected word of {output} bits for an encoder of {input}")
            mend("give {input} to {}", input + MOST_FINER) by(output_bits);
        Polynomial { order: usize } =>
            says("the coefficients have a polynomial of order {order} in place of the turn's harmonics: it \
                does not repeat with the turn")
            mend("fit again with this program, which fits harmonics");
        Steep { slope: f64 } =>
            says("the error changes by up to {slope:.2} counts from count to count: it cannot be turned \
                round to a correction");
        Large => says("the corrections are too large for this form of routine");
        Bound { wanted: f64, half: f64, unit: String, output: u32 } =>
            says("the bound is {wanted:.3e} {unit}, and rounding to {output} bits alone may take half a \
                count, {half:.3e} {unit}")
            mend("ask for more, or for a finer word") by(bound) by(output_bits);
        Nothing { wanted: f64, unit: String, flash: usize, table: usize } =>
            says("no routine within {wanted:.3e} {unit} fits {flash} bytes of flash: a table of every count \
                takes {table} bytes")
            mend("allow more bytes, or a larger bound") by(flash_bytes) by(bound);
    }
}

/// More bits of the result than this are noise.
const MOST_FINER: u32 = 6;

impl Encoder {
    /// The widths, from what is wanted and what the coefficients say.
    ///
    /// # Errors
    /// [`TurnError`] where neither says it, or they contradict each other.
    pub fn words(&self, coefficients: &Coefficients) -> Result<Words, TurnError> {
        let (unit, revolution) = match &coefficients.sensor {
            Sensor::Direct { unit, revolution: Some(revolution) } => (unit, *revolution),
            _ => return Err(TurnError::NotATurn),
        };
        let wanted = match (self.bits, self.counts) {
            (Some(_), Some(_)) => return Err(TurnError::BitsAndCounts),
            (Some(bits), None) if BITS.contains(&bits) => Some((1 << bits, "bits")),
            (Some(bits), None) => return Err(TurnError::Bits { bits }),
            (None, counts) => counts.map(|counts| (counts, "counts")),
        };
        let in_counts = unit == "counts" || unit == "count";
        let counts = match wanted {
            Some((counts, value)) if in_counts && f64::from(counts) != revolution => {
                return Err(TurnError::Contradiction { counts: counts.into(), value, revolution });
            }
            Some((counts, _)) => f64::from(counts),
            None if in_counts => revolution,
            None => match assumed_bits(coefficients) {
                Some(bits) => 2f64.powi(bits as i32),
                None => return Err(TurnError::UnknownBits { unit: unit.clone() }),
            },
        };
        let allowed = f64::from(FEWEST_COUNTS)..=f64::from(MOST_COUNTS);
        if counts.fract() != 0.0 || !allowed.contains(&counts) {
            return Err(TurnError::Counts { counts });
        }
        let words = Words { counts: counts as u32, finer: 0 };
        let (input, output) = (words.input(), self.output_bits.unwrap_or(words.input()));
        if !(input..=input + MOST_FINER).contains(&output) {
            return Err(TurnError::OutputBits { input, output });
        }
        Ok(Words { finer: output - input, ..words })
    }

    /// Whether the width of the word is taken from the noise, for want of another.
    pub fn assumes(&self, coefficients: &Coefficients) -> bool {
        let counts = matches!(&coefficients.sensor, Sensor::Direct { unit, .. } if unit == "counts" || unit == "count");
        !counts && self.bits.is_none() && self.counts.is_none()
    }
}

/// Half a step of the word that is taken where none is named, as a part of the noise: it then adds half a per cent.
const OF_THE_NOISE: f64 = 0.1;

/// The bits of a word whose rounding does not matter beside the noise, within [`BITS`]: where the sensor's unit is not
/// counts and no width is named. None where the file does not tell its noise.
pub fn assumed_bits(coefficients: &Coefficients) -> Option<u32> {
    let revolution = coefficients.turn.as_ref()?.revolution;
    let noise = coefficients.noise()?;
    let bits = (0.5 * revolution / (OF_THE_NOISE * noise)).log2().ceil();
    Some((bits.max(0.0) as u32).clamp(*BITS.start(), *BITS.end()))
}
