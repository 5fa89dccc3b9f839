//! What is known of a step's result on a piece, and how products and sums carry it on.

use super::piece::Piece;
use crate::exact::{Interval, Polynomial};
use crate::program::{Stage, Step, Type};

/// polynomial(u) + error, |error| ≤ evaluation + output, where u is the variable less the piece's centre.
#[derive(Debug, Clone)]
pub(super) struct Inexact {
    pub(super) polynomial: Polynomial,
    /// What the steps of the evaluation contribute to the error.
    pub(super) evaluation: Interval,
    /// What the steps to the output's format contribute.
    pub(super) output: Interval,
}

/// A step's result on a piece, and all that it can be there.
#[derive(Debug, Clone)]
pub(super) struct Value {
    pub(super) sum: Inexact,
    pub(super) range: Interval,
}

/// A constant.
pub(super) fn exactly(constant: Interval) -> Value {
    Value { sum: Inexact::exact(Polynomial::constant(constant.clone())), range: constant }
}

impl Value {
    /// The product of the polynomials, and of each kind of error what reaches it: |a|·e_b + |b|·e_a, where |a|
    /// is the largest computed value, so that e_a·e_b is within.
    pub(super) fn times(&self, b: &Value) -> Inexact {
        let (ra, rb) = (self.range.magnitude(), b.range.magnitude());
        let spread = |ea: &Interval, eb: &Interval| (&(&ra * eb) + &(&rb * ea)).upper();
        Inexact {
            polynomial: self.sum.polynomial.mul(&b.sum.polynomial),
            evaluation: spread(&self.sum.evaluation, &b.sum.evaluation),
            output: spread(&self.sum.output, &b.sum.output),
        }
    }
}

impl Inexact {
    /// Without an error.
    pub(super) fn exact(polynomial: Polynomial) -> Self {
        Inexact { polynomial, evaluation: Interval::zero(), output: Interval::zero() }
    }

    pub(super) fn mul_pow2(&self, by: i64) -> Self {
        Inexact {
            polynomial: self.polynomial.mul_pow2(by),
            evaluation: self.evaluation.mul_pow2(by),
            output: self.output.mul_pow2(by),
        }
    }

    pub(super) fn plus(&self, c: &Inexact) -> Self {
        Inexact {
            polynomial: self.polynomial.add(&c.polynomial),
            evaluation: (&self.evaluation + &c.evaluation).upper(),
            output: (&self.output + &c.output).upper(),
        }
    }

    pub(super) fn less(self, constant: &Interval) -> Self {
        Inexact { polynomial: self.polynomial.sub(&Polynomial::constant(constant.clone())), ..self }
    }

    /// All that it can be on the piece, with a rounding that is still to come.
    pub(super) fn range(&self, rounding: &Interval, piece: &Piece) -> Interval {
        let error = (&(&self.evaluation + &self.output) + rounding).upper();
        &self.polynomial.range_around_zero(&piece.radius) + &error.symmetric()
    }

    /// With a rounding, which is listed where the step belongs.
    pub(super) fn rounded(mut self, step: &Step, rounding: &Interval, piece: &Piece) -> Value {
        let listed = match step.stage {
            Stage::Output => &mut self.output,
            _ => &mut self.evaluation,
        };
        *listed = (&*listed + rounding).upper();
        let range = self.range(&Interval::zero(), piece);
        Value { sum: self, range }
    }
}

/// Half a unit in the last place of a float whose exact value lies in `value`.
pub(super) fn half_ulp(value: &Interval) -> Interval {
    let exponent = value.log2_floor().map_or(-150, |e| (e - 24).max(-150));
    Interval::pow2(exponent)
}

/// All values of an integer type.
pub(crate) fn of_type(ty: Type) -> Interval {
    ty.range().map_or_else(Interval::zero, |(lo, hi)| Interval::between(lo, hi))
}
