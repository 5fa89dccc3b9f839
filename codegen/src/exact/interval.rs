//! Interval arithmetic on dyadic rationals m·2⁻³²⁰ with integers of any length.
//!
//! Sums, differences and products by powers of two are exact; every other operation rounds the two ends
//! outward, so that an interval always contains the real number it stands for. No proof in this program
//! rests on floating point.

use std::ops::{Add, Mul, Neg, Sub};

use dashu_base::{Approximation, BitTest, DivEuclid, FloatEncoding, Sign, Signed};
use dashu_int::IBig;

/// The common exponent: an end is `mantissa · 2^-SCALE`.
const SCALE: usize = 320;

/// A closed interval of real numbers; a point where both ends agree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interval {
    lo: IBig,
    hi: IBig,
}

impl Interval {
    /// The point 0.
    pub fn zero() -> Self {
        Self::from_int(0)
    }

    /// An integer, exactly.
    pub fn from_int(value: i64) -> Self {
        let mantissa = IBig::from(value) << SCALE;
        Interval { lo: mantissa.clone(), hi: mantissa }
    }

    /// 2^`exponent`, exactly for exponents from −320 on.
    pub fn pow2(exponent: i64) -> Self {
        Self::from_int(1).mul_pow2(exponent)
    }

    /// From one integer to another, whichever is less.
    pub fn between(a: i64, b: i64) -> Self {
        Self::from_int(a).hull(&Self::from_int(b))
    }

    /// A finite `f64`, exactly (bits below 2⁻³²⁰ are rounded outward).
    pub fn from_f64(value: f64) -> Self {
        let decoded = value.decode();
        debug_assert!(decoded.is_ok());
        let (mantissa, exponent) = decoded.unwrap_or_default();
        Interval::from_int(mantissa).mul_pow2(exponent.into())
    }

    /// The quotient of two integers, `denominator` > 0.
    pub fn from_ratio(numerator: i64, denominator: i64) -> Self {
        debug_assert!(denominator > 0);
        Interval::from_int(numerator).div(&Interval::from_int(denominator))
    }

    /// The smallest interval that contains both.
    pub fn hull(&self, other: &Interval) -> Self {
        Interval { lo: self.lo.clone().min(other.lo.clone()), hi: self.hi.clone().max(other.hi.clone()) }
    }

    /// What it has in common with an interval that is known to hold the same number.
    pub fn meet(&self, other: &Interval) -> Self {
        Interval { lo: self.lo.clone().max(other.lo.clone()), hi: self.hi.clone().min(other.hi.clone()) }
    }

    /// [−r, r] for the largest magnitude r of `self`.
    pub fn symmetric(&self) -> Self {
        let r = self.magnitude();
        Interval { lo: -r.hi.clone(), hi: r.hi }
    }

    /// The largest absolute value in the interval, as a point.
    pub fn magnitude(&self) -> Self {
        let r = self.hi.clone().max(-self.lo.clone());
        Interval { lo: r.clone(), hi: r }
    }

    /// The lower end, as a point.
    pub fn lower(&self) -> Self {
        Interval { lo: self.lo.clone(), hi: self.lo.clone() }
    }

    /// The upper end, as a point.
    pub fn upper(&self) -> Self {
        Interval { lo: self.hi.clone(), hi: self.hi.clone() }
    }

    /// The midpoint, as a point (rounded down by less than 2⁻³²⁰).
    pub fn midpoint(&self) -> Self {
        let m: IBig = (&self.lo + &self.hi) >> 1;
        Interval { lo: m.clone(), hi: m }
    }

    /// `self · 2^exponent`, exact upward, rounded outward downward.
    pub fn mul_pow2(&self, exponent: i64) -> Self {
        if exponent >= 0 {
            let k = exponent as usize;
            Interval { lo: self.lo.clone() << k, hi: self.hi.clone() << k }
        } else {
            let k = exponent.unsigned_abs() as usize;
            Interval { lo: self.lo.clone() >> k, hi: shr_ceil(&self.hi, k) }
        }
    }

    /// `self / divisor`; the divisor must not contain 0.
    pub fn div(&self, divisor: &Interval) -> Self {
        debug_assert!(
            divisor.lo.is_positive() || divisor.hi.is_negative(),
            "division by an interval around zero"
        );
        if divisor.hi.is_negative() {
            return (-self.clone()).div(&-divisor.clone());
        }
        let ends = [&self.lo, &self.hi];
        let by = [&divisor.lo, &divisor.hi];
        let pairs = || ends.iter().flat_map(|n| by.iter().map(move |d| ((*n).clone() << SCALE, *d)));
        let floor = pairs().map(|(n, d)| n.div_euclid(d)).min();
        let ceil = pairs().map(|(n, d)| -(-n).div_euclid(d)).max();
        Interval { lo: floor.unwrap_or_default(), hi: ceil.unwrap_or_default() }
    }

    fn is_point(&self) -> bool {
        self.lo == self.hi
    }

    /// The sign of all its numbers, 0 counting as either; none where they have both.
    fn sign(&self) -> Option<Sign> {
        if !self.lo.is_negative() {
            Some(Sign::Positive)
        } else {
            (!self.hi.is_positive()).then_some(Sign::Negative)
        }
    }

    /// Whether every number of `self` is less than or equal to every number of `other`.
    pub fn certainly_le(&self, other: &Interval) -> bool {
        self.hi <= other.lo
    }

    /// Whether the interval lies inside `other`.
    pub fn inside(&self, other: &Interval) -> bool {
        other.lo <= self.lo && self.hi <= other.hi
    }

    /// An `f64` that is at least the upper end.
    pub fn to_f64_up(&self) -> f64 {
        to_f64(&self.hi, f64::next_up, Some(Sign::Negative))
    }

    /// An `f64` that is at most the lower end.
    pub fn to_f64_down(&self) -> f64 {
        to_f64(&self.lo, f64::next_down, Some(Sign::Positive))
    }

    /// The `f64` nearest to the midpoint: for search and print, never for proof.
    pub fn to_f64(&self) -> f64 {
        to_f64(&self.midpoint().lo, |v| v, None)
    }

    /// The midpoint rounded to an integer, halves upward; `None` where it exceeds 63 bits.
    pub fn round_to_i64(&self) -> Option<i64> {
        let half = IBig::ONE << (SCALE - 1);
        i64::try_from((self.midpoint().lo + half) >> SCALE).ok()
    }

    /// The largest integer not above the lower end; `None` where it exceeds 63 bits.
    pub fn floor_to_i64(&self) -> Option<i64> {
        i64::try_from(self.lo.clone() >> SCALE).ok()
    }

    /// The smallest integer not below the upper end; `None` where it exceeds 63 bits.
    pub fn ceil_to_i64(&self) -> Option<i64> {
        i64::try_from(shr_ceil(&self.hi, SCALE)).ok()
    }

    /// ⌊log₂ |x|⌋ of the largest magnitude x; `None` for zero.
    pub fn log2_floor(&self) -> Option<i64> {
        let m = self.magnitude().hi;
        (!m.is_zero()).then(|| m.bit_len() as i64 - 1 - SCALE as i64)
    }
}

fn shr_ceil(value: &IBig, k: usize) -> IBig {
    -((-value) >> k)
}

/// Nearest `f64` of `mantissa · 2^-SCALE`, stepped once by `step` where result − exact has the sign `mend`.
fn to_f64(mantissa: &IBig, step: fn(f64) -> f64, mend: Option<Sign>) -> f64 {
    let scale = f64::from_bits((1023 - SCALE as u64) << 52);
    match mantissa.to_f64() {
        Approximation::Exact(v) => v * scale,
        Approximation::Inexact(v, error) => {
            let v = v * scale;
            if mend == Some(error) { step(v) } else { v }
        }
    }
}

impl Neg for Interval {
    type Output = Interval;
    fn neg(self) -> Interval {
        Interval { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for &Interval {
    type Output = Interval;
    fn add(self, other: &Interval) -> Interval {
        Interval { lo: &self.lo + &other.lo, hi: &self.hi + &other.hi }
    }
}

impl Sub for &Interval {
    type Output = Interval;
    fn sub(self, other: &Interval) -> Interval {
        Interval { lo: &self.lo - &other.hi, hi: &self.hi - &other.lo }
    }
}

impl Mul for &Interval {
    type Output = Interval;
    fn mul(self, other: &Interval) -> Interval {
        let (a, b) = (self, other);
        if a.is_point() && b.is_point() {
            let product = &a.lo * &b.lo;
            return Interval { hi: shr_ceil(&product, SCALE), lo: product >> SCALE };
        }
        // Which ends make the least and the largest product follows from the signs.
        let (lo, hi) = match (a.sign(), b.sign()) {
            (Some(Sign::Positive), Some(Sign::Positive)) => (&a.lo * &b.lo, &a.hi * &b.hi),
            (Some(Sign::Positive), Some(Sign::Negative)) => (&a.hi * &b.lo, &a.lo * &b.hi),
            (Some(Sign::Negative), Some(Sign::Positive)) => (&a.lo * &b.hi, &a.hi * &b.lo),
            (Some(Sign::Negative), Some(Sign::Negative)) => (&a.hi * &b.hi, &a.lo * &b.lo),
            (Some(Sign::Positive), None) => (&a.hi * &b.lo, &a.hi * &b.hi),
            (Some(Sign::Negative), None) => (&a.lo * &b.hi, &a.lo * &b.lo),
            (None, Some(Sign::Positive)) => (&a.lo * &b.hi, &a.hi * &b.hi),
            (None, Some(Sign::Negative)) => (&a.hi * &b.lo, &a.lo * &b.lo),
            (None, None) => ((&a.lo * &b.hi).min(&a.hi * &b.lo), (&a.lo * &b.lo).max(&a.hi * &b.hi)),
        };
        Interval { lo: lo >> SCALE, hi: shr_ceil(&hi, SCALE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn shifts_round_toward_minus_infinity() {
        assert_eq!(IBig::from(-3) >> 1, IBig::from(-2));
        assert_eq!(shr_ceil(&IBig::from(-3), 1), IBig::from(-1));
        assert_eq!(IBig::from(-7).div_euclid(IBig::from(2)), IBig::from(-4));
    }

    #[test]
    fn a_third_is_enclosed() {
        let third = Interval::from_ratio(1, 3);
        let three = Interval::from_int(3);
        let one = Interval::from_int(1);
        assert!(one.inside(&(&third * &three)));
        assert!(third.lo < third.hi);
        assert!(third.to_f64_down() < third.to_f64_up());
    }

    /// Whatever the signs of the ends, the product is that of all pairs of ends.
    #[test]
    fn a_product_spans_those_of_the_ends() {
        let numbers = [-3, -1, 0, 2, 5];
        let ends = || numbers.iter().flat_map(|a| numbers.map(|b| (*a, b))).filter(|(a, b)| a <= b);
        for (a, b) in ends().flat_map(|a| ends().map(move |b| (a, b))) {
            let products = [a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1];
            let (least, largest) = (products.into_iter().min(), products.into_iter().max());
            let spanned = Interval::between(least.unwrap(), largest.unwrap());
            assert_eq!(&Interval::between(a.0, a.1) * &Interval::between(b.0, b.1), spanned, "{a:?} {b:?}");
        }
    }

    proptest! {
        #[test]
        fn f64_survive(value in -1e30..1e30f64) {
            let x = Interval::from_f64(value);
            prop_assert_eq!(x.to_f64(), value);
            prop_assert_eq!(x.to_f64_up(), value);
            prop_assert_eq!(x.to_f64_down(), value);
        }

        #[test]
        fn products_and_quotients_enclose(a in -1e3..1e3f64, b in 1e-3..1e3f64) {
            let (x, y) = (Interval::from_f64(a), Interval::from_f64(b));
            let back = &x.div(&y) * &y;
            prop_assert!(x.inside(&back));
            prop_assert!((&x * &y).to_f64_down() <= a * b * (1.0 + 1e-15 * a.signum()));
        }
    }
}
