//! The value of a part of an expression before it becomes a word: a constant and polynomials, each of one word.
//!
//! Sums, differences, products by numbers and powers of one word cost nothing that way, and what cancels is gone: only
//! where an operator needs its argument as one word are steps appended (`words`).

use std::collections::BTreeMap;

use super::super::builder::Tracked;
use super::super::shape::Shape;
use crate::exact::{Interval, Polynomial};

/// Degree up to which products of polynomials of one word stay one polynomial; of the reading, whose angle is a long
/// series, any, since a short polynomial takes its place.
const LARGEST_DEGREE: usize = 8;
/// The number of the reading's variable among the words.
pub(super) const READING: usize = 0;

/// A word of which values are polynomials: v = word·2^−exponent.
#[derive(Debug, Clone)]
pub(super) struct Base {
    pub word: Tracked,
    pub exponent: i64,
    /// All that v and what it would be exactly can be.
    pub ends: (Interval, Interval),
}

impl Base {
    /// A word whose exact value is as far away as its error says.
    pub fn of(word: Tracked, exponent: i64) -> Base {
        let reach = (&word.range + &word.error.symmetric()).mul_pow2(-exponent);
        Base { word, exponent, ends: (reach.lower(), reach.upper()) }
    }

    /// How far v is from exact.
    pub fn error(&self) -> Interval {
        self.word.error.mul_pow2(-self.exponent)
    }

    /// Takes note that v, exactly, lies between these ends.
    fn narrow(&mut self, ends: &Interval) {
        let ends = self.ends.0.hull(&self.ends.1).meet(ends);
        let reach = (&ends + &self.error().symmetric()).mul_pow2(self.exponent);
        self.word.range = self.word.range.meet(&reach);
        self.ends = (ends.lower(), ends.upper());
    }

    /// The largest |v|.
    pub fn radius(&self) -> Interval {
        self.ends.0.hull(&self.ends.1).magnitude()
    }
}

/// constant + Σ polynomial(word), the polynomials without a constant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Value {
    pub constant: Interval,
    /// By the number of the word.
    pub parts: BTreeMap<usize, Shape>,
    /// All that it can be.
    pub range: Interval,
}

impl Value {
    pub fn number(constant: Interval) -> Value {
        Value { range: constant.clone(), constant, parts: BTreeMap::new() }
    }

    /// A polynomial of word number `of`.
    pub fn of(bases: &[Base], of: usize, shape: Shape) -> Value {
        let (from, to) = &bases[of].ends;
        let range = &shape.polynomial.range(from, to) + &shape.remainder.symmetric();
        let mut coefficients = shape.polynomial.coefficients().to_vec();
        let constant = std::mem::replace(&mut coefficients[0], Interval::zero());
        let polynomial = Polynomial::new(coefficients);
        Value { constant, parts: [(of, Shape { polynomial, ..shape })].into(), range }
    }

    pub fn is_constant(&self) -> bool {
        self.parts.is_empty()
    }

    pub fn plus(&self, other: &Value) -> Value {
        let mut sum = self.clone();
        sum.constant = &sum.constant + &other.constant;
        sum.range = &sum.range + &other.range;
        for (of, shape) in &other.parts {
            let there = sum.parts.get(of).map_or(shape.clone(), |there| there.plus(shape));
            sum.parts.insert(*of, there);
        }
        sum
    }

    pub fn scaled(&self, factor: &Interval) -> Value {
        let parts = self.parts.iter().map(|(of, shape)| (*of, shape.scaled(factor)));
        Value { constant: &self.constant * factor, parts: parts.collect(), range: &self.range * factor }
    }

    pub fn less(&self, other: &Value) -> Value {
        self.plus(&other.scaled(&Interval::from_int(-1)))
    }

    /// What it can be, as its polynomials say: no more than is known otherwise.
    pub fn narrowed(mut self, bases: &[Base]) -> Value {
        let parts = self.parts.iter().map(|(of, shape)| {
            let (from, to) = &bases[*of].ends;
            &shape.polynomial.range(from, to) + &shape.remainder.symmetric()
        });
        let range = parts.fold(self.constant.clone(), |sum, part| &sum + &part);
        self.range = self.range.meet(&range);
        self
    }

    /// The word that it is an affine function of, with offset and slope by v.
    pub fn affine(&self) -> Option<(usize, Interval, Interval)> {
        let (of, shape) = self.parts.first_key_value()?;
        let exact = shape.remainder == Interval::zero() && shape.polynomial.coefficients().len() == 2;
        let slope = shape.polynomial.coefficients().get(1)?.clone();
        let changes = !Interval::zero().inside(&slope);
        (exact && changes && self.parts.len() == 1).then_some((*of, self.constant.clone(), slope))
    }

    /// Takes note that it lies in a range.
    pub fn within(mut self, bases: &mut [Base], range: &Interval) -> Value {
        self.range = self.range.meet(range);
        if let Some((of, offset, slope)) = self.affine() {
            bases[of].narrow(&(&self.range - &offset).div(&slope));
        }
        self
    }

    /// The product, where it is a polynomial of one word of no high degree.
    pub fn times(&self, other: &Value, bases: &[Base]) -> Option<Value> {
        if self.is_constant() {
            return Some(other.scaled(&self.constant));
        }
        if other.is_constant() {
            return Some(self.scaled(&other.constant));
        }
        let [(a, of_a), (b, of_b)] = [self.parts.first_key_value()?, other.parts.first_key_value()?];
        let degree = |shape: &Shape| shape.polynomial.coefficients().len() - 1;
        let short = *a == READING || degree(of_a) + degree(of_b) <= LARGEST_DEGREE;
        if self.parts.len() + other.parts.len() > 2 || a != b || !short {
            return None;
        }
        let whole = |shape: &Shape, constant: &Interval| shape.plus(&Shape::constant(constant.clone()));
        let (of_a, of_b) = (whole(of_a, &self.constant), whole(of_b, &other.constant));
        let mut product = Value::of(bases, *a, of_a.times(&of_b, &bases[*a].radius()));
        product.range = product.range.meet(&(&self.range * &other.range));
        Some(product)
    }
}
