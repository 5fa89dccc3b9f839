//! Double-double arithmetic: an unevaluated sum of two `f64`, some 32 decimal digits (Dekker 1971; error
//! bounds in Joldes, Muller & Popescu 2017). Used where a result must be the exact one, rounded once:
//! the least-squares solution, and its conversion to powers of s.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, |lo| ≤ ulp(hi)/2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Double {
    pub hi: f64,
    pub lo: f64,
}

impl Double {
    pub const ZERO: Double = Double { hi: 0.0, lo: 0.0 };
    pub const ONE: Double = Double { hi: 1.0, lo: 0.0 };

    /// a + b, exactly.
    fn two_sum(a: f64, b: f64) -> Double {
        let hi = a + b;
        let part = hi - a;
        Double { hi, lo: (a - (hi - part)) + (b - part) }
    }

    /// a + b, exactly where |a| ≥ |b|.
    fn quick_two_sum(a: f64, b: f64) -> Double {
        let hi = a + b;
        Double { hi, lo: b - (hi - a) }
    }

    /// a·b, exactly.
    pub fn product(a: f64, b: f64) -> Double {
        let hi = a * b;
        Double { hi, lo: a.mul_add(b, -hi) }
    }

    /// Rounded to the nearest `f64`.
    pub fn round(self) -> f64 {
        self.hi + self.lo
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Double {
        Double { hi: value, lo: 0.0 }
    }
}

impl Neg for Double {
    type Output = Double;
    fn neg(self) -> Double {
        Double { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Double {
    type Output = Double;
    fn add(self, other: Double) -> Double {
        let (s, t) = (Double::two_sum(self.hi, other.hi), Double::two_sum(self.lo, other.lo));
        let v = Double::quick_two_sum(s.hi, s.lo + t.hi);
        Double::quick_two_sum(v.hi, v.lo + t.lo)
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, other: Double) -> Double {
        self + -other
    }
}

impl Mul<f64> for Double {
    type Output = Double;
    fn mul(self, other: f64) -> Double {
        let p = Double::product(self.hi, other);
        Double::quick_two_sum(p.hi, self.lo.mul_add(other, p.lo))
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, other: Double) -> Double {
        let p = Double::product(self.hi, other.hi);
        Double::quick_two_sum(p.hi, p.lo + self.hi.mul_add(other.lo, self.lo * other.hi))
    }
}

impl Div for Double {
    type Output = Double;
    fn div(self, other: Double) -> Double {
        let first = self.hi / other.hi;
        let rest = self - other * first;
        let second = rest.hi / other.hi;
        let rest = rest - other * second;
        Double::quick_two_sum(first, second) + Double::from(rest.hi / other.hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (1/3)·3, (√2-like)² and differences are right to 100 bits, where `f64` has 53.
    #[test]
    fn carries_thirty_digits() {
        let third = Double::ONE / Double::from(3.0);
        let rest = third * 3.0 - Double::ONE;
        assert!(rest.round().abs() < 1e-31, "{rest:?}");
        let tenth = Double::ONE / Double::from(10.0);
        let sum = (0..10).fold(Double::ZERO, |sum, _| sum + tenth);
        assert!((sum - Double::ONE).round().abs() < 1e-30);
        let x = Double { hi: 1.0, lo: 1e-20 };
        assert_eq!((x * x - Double::ONE).round(), 2e-20);
    }
}
