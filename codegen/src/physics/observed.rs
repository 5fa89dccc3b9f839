//! What a term observes: a function of the reading, or a further input; either way a number that lies within a
//! known range and becomes a word of a wanted scale.

use super::Result;
use super::builder::{Builder, Tracked};
use super::further::Given;
use super::shape::{Shape, Variable};
use super::sum::fitted;
use crate::exact::Interval;

/// See the module.
pub(super) enum Observed<'a> {
    /// A function of the reading.
    Reading(&'a Variable<'a>, Shape),
    /// A further input, scaled and shifted.
    Given(Given),
}

impl<'a> Observed<'a> {
    /// The observable of this name, where the routine has it.
    pub fn of(name: &str, variable: &'a Variable<'a>, given: &[(String, Given)]) -> Result<Option<Self>> {
        if let Some(shape) = variable.observable(name)? {
            return Ok(Some(Observed::Reading(variable, shape)));
        }
        Ok(given.iter().find(|(input, _)| input == name).map(|(_, g)| Observed::Given(g.clone())))
    }

    /// (observable − at)·factor.
    pub fn affine(&self, at: &Interval, factor: &Interval) -> Self {
        match self {
            Observed::Reading(variable, shape) => {
                let less = shape.plus(&Shape::constant(-at.clone()));
                Observed::Reading(variable, less.scaled(factor))
            }
            Observed::Given(given) => Observed::Given(Given {
                word: given.word.clone(),
                offset: &(&given.offset - at) * factor,
                slope: &given.slope * factor,
            }),
        }
    }

    /// All that it can be.
    pub fn range(&self) -> Interval {
        match self {
            Observed::Reading(variable, shape) => variable.range(shape),
            Observed::Given(given) => &given.offset + &(&given.slope * &given.word.range.mul_pow2(-32)),
        }
    }

    /// The bits with which the largest of it, in magnitude, is a word of 2^29…2^30; fewer where a polynomial of the
    /// reading has a larger coefficient than half a word holds, because the range is far from filling the variable's.
    pub fn bits(&self) -> i64 {
        let mut largest = self.range().magnitude();
        if let Observed::Reading(_, shape) = self {
            for c in shape.polynomial.coefficients().iter().skip(1) {
                largest = largest.hull(&c.magnitude().mul_pow2(-1)).magnitude();
            }
        }
        29 - largest.log2_floor().unwrap_or(0)
    }

    /// Appends the steps to the word of observable·2^bits, within `tolerance` words where the format allows.
    pub fn word(&self, b: &mut Builder, name: &str, bits: i64, tolerance: &Interval) -> Result<Tracked> {
        match self {
            Observed::Reading(variable, shape) => variable.evaluate(b, name, shape, bits, tolerance, ""),
            Observed::Given(given) => {
                let (slope, shift) = fitted(&given.slope.mul_pow2(bits), 8)?;
                let offset = Tracked::constant(&given.offset.mul_pow2(bits));
                b.mul_add(name, (&slope, &given.word), shift, &offset, "")
            }
        }
    }
}
