//! Further inputs of a routine, a temperature for example: the form in which they arrive, the box in which they
//! are valid, and the words that they become.

use super::builder::{Builder, Tracked};
use super::{PhysicsError, Result};
use crate::exact::Interval;
use crate::input::{exponent_above, power_of_two};
use crate::program::{Argument, Op, Program, Type};

/// A further input as the user describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Further {
    /// Name of the observable, as in the recording's column.
    pub observable: String,
    /// Smallest valid value, in the unit of the observable.
    pub from: f64,
    /// Largest valid value.
    pub to: f64,
    /// How it arrives.
    pub encoding: FurtherEncoding,
}

/// The form in which a further input arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FurtherEncoding {
    /// `i32`, 2⁻³¹ of the smallest power of two that is twice the largest value of the box or more.
    Q31,
    /// Counts of a converter: value = (count − offset)·gain.
    Counts {
        /// Width of the converter's word, 1 to 16.
        bits: u32,
        /// Change of the value by one count, above zero.
        gain: f64,
        /// The count that stands for zero.
        offset: f64,
    },
}

/// A further input in a program: observable = offset + slope·v, the word being v·2³².
#[derive(Debug, Clone)]
pub(super) struct Given {
    pub word: Tracked,
    pub offset: Interval,
    pub slope: Interval,
}

impl Further {
    /// Reads `temperature_c=15..35` or `temperature_c=15..35:counts:12:0.05:-400` (bits, gain, offset).
    ///
    /// # Errors
    /// [`PhysicsError::Further`], which says what is expected.
    pub fn parse(text: &str) -> Result<Further> {
        let wrong = || PhysicsError::Further(text.into());
        let (observable, rest) = text.split_once('=').ok_or_else(wrong)?;
        let mut parts = rest.split(':');
        let (from, to) = parts.next().and_then(|range| range.split_once("..")).ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
        let (from, to) = (number(from)?, number(to)?);
        let encoding = match parts.collect::<Vec<_>>()[..] {
            [] | ["q31"] => FurtherEncoding::Q31,
            ["counts", bits, gain, offset] => FurtherEncoding::Counts {
                bits: bits.parse().ok().filter(|b| (1..=16).contains(b)).ok_or_else(wrong)?,
                gain: number(gain)?,
                offset: number(offset)?,
            },
            _ => return Err(wrong()),
        };
        let positive = !matches!(encoding, FurtherEncoding::Counts { gain, .. } if gain <= 0.0);
        if !(from < to && positive && crate::name::is_identifier(observable)) {
            return Err(wrong());
        }
        Ok(Further { observable: observable.into(), from, to, encoding })
    }

    /// The words of the box: those to which the routine promises to limit.
    pub(crate) fn words(&self, program: &Program) -> Option<(f64, f64)> {
        let limited = format!("{}_limited", self.observable);
        program.steps.iter().find_map(|s| match s.op {
            Op::Clamp { lo, hi, .. } if s.name == limited => Some((lo as f64, hi as f64)),
            _ => None,
        })
    }

    /// Appends the argument and the steps to its word, centred where the observable is `centre`.
    pub(super) fn push(&self, b: &mut Builder, centre: f64) -> Result<Given> {
        let largest = self.from.abs().max(self.to.abs());
        let (lsb, zero, ty, words, suffix, meaning) = match self.encoding {
            FurtherEncoding::Q31 => {
                let full_scale = power_of_two(exponent_above(largest) + 1);
                let meaning = format!("2⁻³¹ of {full_scale} in the unit of `{}`", self.observable);
                let lsb = Interval::from_f64(full_scale).mul_pow2(-31);
                (lsb, 0.0, Type::I32, (i32::MIN.into(), i32::MAX.into()), "q31", meaning)
            }
            FurtherEncoding::Counts { bits, gain, offset } => {
                let meaning = format!("counts of a {bits}-bit converter, {gain} each, zero at {offset}");
                (Interval::from_f64(gain), offset, Type::U16, (0, (1i64 << bits) - 1), "counts", meaning)
            }
        };
        let zero = Interval::from_f64(zero);
        let in_words = |value: f64| &Interval::from_f64(value).div(&lsb) + &zero;
        let first = in_words(self.from).ceil_to_i64().unwrap_or(i64::MIN);
        let last = in_words(self.to).floor_to_i64().unwrap_or(i64::MAX);
        if first < words.0 || last > words.1 || first >= last {
            let value = |word: i64| ((&Interval::from_int(word) - &zero).to_f64()) * lsb.to_f64();
            return Err(PhysicsError::Box {
                observable: self.observable.clone(),
                from: self.from,
                to: self.to,
                reaches: (value(words.0), value(words.1)),
            });
        }
        let middle = in_words(centre).round_to_i64().unwrap_or(0).clamp(first, last);

        let name = &self.observable;
        let meaning = format!("`{name}`, {meaning}, valid for {}…{}", self.from, self.to);
        let argument = format!("{name}_{suffix}");
        if b.program.arguments.iter().any(|other| other.name == argument) {
            return Err(PhysicsError::Taken(name.clone()));
        }
        let mut word = b.argument(Argument { name: argument, ty, meaning });
        word = b.clamp(&format!("{name}_limited"), &word, (first, last), &Interval::zero(), "its box")?;
        if middle != 0 {
            let centre = Tracked::constant(&Interval::from_int(middle));
            word = b.sub(&format!("{name}_offset"), &word, &centre)?;
        }
        let widest = (last - middle).max(middle - first);
        let left = (0..31).take_while(|by| widest << by <= i64::from(i32::MAX)).last().unwrap_or(0);
        if left > 0 {
            word = b.shift_left(&format!("{name}_x"), &word, left, "v·2^32")?;
        }
        // word = (w − middle)·2^left = v·2³², observable = (w − zero)·lsb.
        Ok(Given {
            word,
            offset: &(&Interval::from_int(middle) - &zero) * &lsb,
            slope: &Interval::pow2(32 - i64::from(left)) * &lsb,
        })
    }
}
