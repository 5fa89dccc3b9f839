//! Functions of the reading alone, as polynomials of the routine's variable v with a remainder: the angle in
//! some unit, its powers, and what a term makes of them.

use fitter::error_model::{ErrorModel, Sensor};

use super::Result;
use super::builder::{Builder, Tracked};
use crate::approximate::minimax;
use crate::exact::{Interval, Polynomial, arcsec_per_rad};
use crate::input::InputPlan;
use crate::reference::TooSteep;

/// The highest degree that is tried.
const LARGEST_DEGREE: usize = 12;
/// Part of a product's polynomial that is dropped, relative to 1, as a power of two.
const DROPPED_LOG2: i64 = -120;

/// A function of v, enclosed over the range.
pub(super) use crate::reference::Reference as Shape;

/// The variable: its range, the reading that it stands for, and the sensor.
pub(super) struct Variable<'a> {
    pub model: &'a ErrorModel,
    pub plan: &'a InputPlan,
    /// The word of the program, v·2^exponent.
    pub word: Tracked,
    pub exponent: i64,
}

impl Variable<'_> {
    /// The largest |v|.
    pub fn radius(&self) -> Interval {
        let (from, to) = self.plan.reach_in_v();
        from.hull(&to).magnitude()
    }

    /// The observable of this name, where it is a function of the reading.
    pub fn observable(&self, name: &str) -> Result<Option<Shape>, TooSteep> {
        let map = &self.plan.map;
        let reading = Polynomial::linear(map.offset.clone(), map.slope.clone());
        let exactly = |polynomial| Shape { polynomial, remainder: Interval::zero() };
        let pair = matches!(self.model.sensor, Sensor::EddyCurrentPair { .. });
        let scale = match name {
            "s_mm" if pair => return Ok(Some(exactly(reading))),
            "measured" if !pair => return Ok(Some(exactly(reading))),
            "angle_arcsec" if pair => arcsec_per_rad(),
            "angle_deg" if pair => arcsec_per_rad().div(&Interval::from_int(3600)),
            _ => return Ok(None),
        };
        let calculated = ErrorModel { coefficients: vec![0.0], ..self.model.clone() };
        let (from, to) = self.plan.reach_in_v();
        Ok(Some(Shape::new(&calculated, map, &from, &to)?.scaled(&scale)))
    }

    /// All that a shape can be.
    pub fn range(&self, shape: &Shape) -> Interval {
        let (from, to) = self.plan.reach_in_v();
        &shape.polynomial.range(&from, &to) + &shape.remainder.symmetric()
    }

    /// Appends the steps that evaluate `shape` as a word of shape·2^bits, with the lowest degree that is within
    /// `tolerance` words where one is; the error holds whatever the tolerance.
    pub fn evaluate(
        &self,
        b: &mut Builder,
        name: &str,
        shape: &Shape,
        bits: i64,
        tolerance: &Interval,
        note: &str,
    ) -> Result<Tracked> {
        let (best, distance) = best_within(shape, &self.plan.reach_in_v(), &tolerance.mul_pow2(-bits));
        let mut sum = horner(b, name, &best, bits, (&self.word, self.exponent), note)?;
        sum.error = (&sum.error + &distance.mul_pow2(bits)).upper();
        Ok(sum)
    }
}

/// Appends Horner's scheme for polynomial(v)·2^bits, the word being v·2^exponent.
pub(super) fn horner(
    b: &mut Builder,
    name: &str,
    polynomial: &Polynomial,
    bits: i64,
    (word, exponent): (&Tracked, i64),
    note: &str,
) -> Result<Tracked> {
    let c: Vec<Tracked> =
        polynomial.coefficients().iter().map(|c| Tracked::constant(&c.mul_pow2(bits))).collect();
    let mut sum = c[c.len() - 1].clone();
    for (k, next) in c.iter().enumerate().rev().skip(1) {
        let said = if k == 0 { note } else { "" };
        sum = b.mul_add(name, (&sum, word), (32 - exponent) as u32, next, said)?;
    }
    Ok(sum)
}

/// The polynomial of the lowest degree that is within `tolerance` of the shape, and its certified distance; the
/// shape's own where none of a lower degree is.
pub(super) fn best_within(
    shape: &Shape,
    (from, to): &(Interval, Interval),
    tolerance: &Interval,
) -> (Polynomial, Interval) {
    let degree = shape.polynomial.coefficients().len().saturating_sub(1);
    for lower in 0..degree.min(LARGEST_DEGREE) {
        let best = if lower == 0 {
            Polynomial::constant(shape.polynomial.range(from, to).midpoint())
        } else {
            minimax(&shape.polynomial, lower, from, to)
        };
        let supremum = best.sub(&shape.polynomial).supremum(from, to, &tolerance.mul_pow2(-6));
        let distance = (&supremum.magnitude() + &shape.remainder).upper();
        if distance.certainly_le(tolerance) {
            return (best, distance);
        }
    }
    (shape.polynomial.clone(), shape.remainder.clone())
}

impl Shape {
    pub(crate) fn constant(value: Interval) -> Shape {
        Shape { polynomial: Polynomial::constant(value), remainder: Interval::zero() }
    }

    pub(super) fn scaled(&self, factor: &Interval) -> Shape {
        let remainder = (&self.remainder * &factor.magnitude()).upper();
        Shape { polynomial: self.polynomial.scale(factor), remainder }
    }

    /// The product where |v| is at most `radius`; high terms of next to nothing are dropped.
    pub(super) fn times(&self, other: &Shape, radius: &Interval) -> Shape {
        let sup = |shape: &Shape| shape.polynomial.range_around_zero(radius).magnitude();
        let spread = &(&sup(other) + &other.remainder) * &self.remainder;
        let mut polynomial = self.polynomial.mul(&other.polynomial);
        let dropped = polynomial.truncate(radius, &Interval::pow2(DROPPED_LOG2));
        let remainder = (&(&(&sup(self) * &other.remainder) + &spread) + &dropped).upper();
        Shape { polynomial, remainder }
    }

    pub(super) fn plus(&self, other: &Shape) -> Shape {
        let remainder = (&self.remainder + &other.remainder).upper();
        Shape { polynomial: self.polynomial.add(&other.polynomial), remainder }
    }

    pub(super) fn less(&self, constant: f64) -> Shape {
        let constant = Polynomial::constant(Interval::from_f64(constant));
        Shape { polynomial: self.polynomial.sub(&constant), remainder: self.remainder.clone() }
    }
}
