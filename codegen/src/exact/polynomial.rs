//! Polynomials with interval coefficients, and certified bounds of what they reach on an interval.

use super::Interval;

/// c₀ + c₁v + c₂v² + … with the coefficients enclosed; never empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    coefficients: Vec<Interval>,
}

impl Polynomial {
    /// From c₀, c₁, c₂, …
    pub fn new(mut coefficients: Vec<Interval>) -> Self {
        if coefficients.is_empty() {
            coefficients.push(Interval::zero());
        }
        Polynomial { coefficients }
    }

    /// A constant.
    pub fn constant(value: Interval) -> Self {
        Polynomial { coefficients: vec![value] }
    }

    /// c₀ + c₁v.
    pub fn linear(c0: Interval, c1: Interval) -> Self {
        Polynomial { coefficients: vec![c0, c1] }
    }

    /// The coefficients, constant first.
    pub fn coefficients(&self) -> &[Interval] {
        &self.coefficients
    }

    /// The value at `v` (Horner).
    pub fn at(&self, v: &Interval) -> Interval {
        self.coefficients.iter().rev().fold(Interval::zero(), |sum, c| &(&sum * v) + c)
    }

    /// Sum.
    pub fn add(&self, other: &Polynomial) -> Self {
        self.zip(other, |a, b| a + b)
    }

    /// Difference.
    pub fn sub(&self, other: &Polynomial) -> Self {
        self.zip(other, |a, b| a - b)
    }

    fn zip(&self, other: &Polynomial, op: impl Fn(&Interval, &Interval) -> Interval) -> Self {
        let zero = Interval::zero();
        let n = self.coefficients.len().max(other.coefficients.len());
        let at = |p: &Polynomial, k: usize| p.coefficients.get(k).unwrap_or(&zero).clone();
        Polynomial::new((0..n).map(|k| op(&at(self, k), &at(other, k))).collect())
    }

    /// Product.
    pub fn mul(&self, other: &Polynomial) -> Self {
        let mut product = vec![Interval::zero(); self.coefficients.len() + other.coefficients.len() - 1];
        for (i, a) in self.coefficients.iter().enumerate() {
            for (j, b) in other.coefficients.iter().enumerate() {
                product[i + j] = &product[i + j] + &(a * b);
            }
        }
        Polynomial::new(product)
    }

    /// Product with a number.
    pub fn scale(&self, factor: &Interval) -> Self {
        Polynomial::new(self.coefficients.iter().map(|c| c * factor).collect())
    }

    /// Product with a power of two.
    pub fn mul_pow2(&self, exponent: i64) -> Self {
        Polynomial::new(self.coefficients.iter().map(|c| c.mul_pow2(exponent)).collect())
    }

    /// The same function of v·2^exponent: p(2^exponent v).
    pub fn stretch_pow2(&self, exponent: i64) -> Self {
        let stretched = self.coefficients.iter().zip(0..).map(|(c, k)| c.mul_pow2(exponent * k));
        Polynomial::new(stretched.collect())
    }

    /// The Taylor shift p(centre + h) as a polynomial of h.
    pub fn shift(&self, centre: &Interval) -> Self {
        let mut c = self.coefficients.clone();
        for first in 0..c.len() {
            for k in (first..c.len() - 1).rev() {
                c[k] = &c[k] + &(&c[k + 1] * centre);
            }
        }
        Polynomial::new(c)
    }

    /// The derivative.
    pub fn derivative(&self) -> Self {
        let d = self.coefficients.iter().zip(0..).skip(1).map(|(c, k)| c * &Interval::from_int(k));
        Polynomial::new(d.collect())
    }

    /// Drops the highest terms whose sum stays below `tolerance` where |v| ≤ `radius`; returns what was
    /// dropped at most.
    pub fn truncate(&mut self, radius: &Interval, tolerance: &Interval) -> Interval {
        let one = Interval::from_int(1);
        let powers: Vec<Interval> = std::iter::successors(Some(one), |p| Some((p * radius).upper()))
            .take(self.coefficients.len())
            .collect();
        let mut dropped = Interval::zero();
        while self.coefficients.len() > 1 {
            let k = self.coefficients.len() - 1;
            let next = (&dropped + &(&self.coefficients[k].magnitude() * &powers[k])).upper();
            if !next.certainly_le(tolerance) {
                break;
            }
            dropped = next;
            self.coefficients.pop();
        }
        dropped
    }

    /// An enclosure of the values for |v| ≤ `radius`: centred form, first order exact.
    pub fn range_around_zero(&self, radius: &Interval) -> Interval {
        let outward = |spread: Interval, c: &Interval| (&(&c.magnitude() + &spread) * radius).upper();
        let spread = self.coefficients[1..].iter().rev().fold(Interval::zero(), outward);
        &self.coefficients[0] + &spread.symmetric()
    }

    /// An enclosure of the values on [`from`, `to`] (points).
    pub fn range(&self, from: &Interval, to: &Interval) -> Interval {
        let centre = from.hull(to).midpoint();
        let radius = (to - &centre).magnitude().hull(&(from - &centre).magnitude()).upper();
        self.shift(&centre).range_around_zero(&radius)
    }

    /// A certified enclosure of max |p(v)| over [`from`, `to`] (points): its upper end is an upper bound
    /// of the maximum and as a rule exceeds it by at most `tolerance`; its lower end is reached.
    ///
    /// Branch and bound: each piece is bounded by its centred form, which near an extremum is off by the
    /// square of the piece's width only. A piece's polynomial is its parent's, shifted; the high terms that
    /// no longer matter on it are dropped and their bound is kept. After `MOST_PIECES` of them the bound stays as
    /// coarse as it is: then it may exceed the maximum by more than the tolerance, but is a bound.
    pub fn supremum(&self, from: &Interval, to: &Interval, tolerance: &Interval) -> Interval {
        self.supremum_beside(from, to, tolerance, &Interval::zero())
    }

    /// The same of the larger of |p| and `least`, which is found sooner where |p| stays below.
    pub fn supremum_beside(
        &self,
        from: &Interval,
        to: &Interval,
        tolerance: &Interval,
        least: &Interval,
    ) -> Interval {
        let centre = from.hull(to).midpoint();
        let radius = (&from.hull(to) - &centre).magnitude();
        let mut reached = self.at(from).magnitude_lower().magnitude_max(least);
        let mut bound = least.clone();
        let mut open =
            vec![Piece { local: self.shift(&centre), radius, dropped: Interval::zero(), depth: 2 }];
        let mut pieces = 0;
        while let Some(piece) = open.pop() {
            pieces += 1;
            let slack = piece.dropped.symmetric();
            let middle = (&piece.local.coefficients[0] + &slack).magnitude_lower();
            if reached.certainly_le(&middle) {
                reached = middle;
            }
            let here = (&piece.local.range_around_zero(&piece.radius) + &slack).magnitude();
            if here.certainly_le(&bound) {
                continue;
            }
            let fine = here.certainly_le(&(&reached + tolerance));
            if fine || piece.depth > DEEPEST || pieces > MOST_PIECES {
                bound = bound.magnitude_max(&here);
            } else {
                open.extend(piece.halves(tolerance));
            }
        }
        reached.hull(&bound)
    }
}

/// Halvings after which a piece is bounded as it is.
const DEEPEST: i64 = 80;
/// Pieces after which the rest is bounded as it is.
const MOST_PIECES: usize = 1 << 14;

/// Part of an interval, with the polynomial about its middle; `dropped` bounds what that leaves out.
struct Piece {
    local: Polynomial,
    radius: Interval,
    dropped: Interval,
    depth: i64,
}

impl Piece {
    /// Both halves. All that is ever dropped on the way down stays below half the tolerance.
    fn halves(&self, tolerance: &Interval) -> [Piece; 2] {
        let half = self.radius.mul_pow2(-1).upper();
        [-half.clone(), half.clone()].map(|middle| {
            let mut local = self.local.shift(&middle);
            let more = local.truncate(&half, &tolerance.mul_pow2(-self.depth));
            let dropped = (&self.dropped + &more).upper();
            Piece { local, radius: half.clone(), dropped, depth: self.depth + 1 }
        })
    }
}

impl Interval {
    /// The smallest absolute value that is certainly reached by the enclosed number, as a point.
    pub(crate) fn magnitude_lower(&self) -> Interval {
        let (lo, hi) = (self.lower(), self.upper());
        let zero = Interval::zero();
        if zero.certainly_le(&lo) {
            lo
        } else if hi.certainly_le(&zero) {
            -hi
        } else {
            zero
        }
    }

    /// The larger of two magnitudes, as points.
    pub(crate) fn magnitude_max(&self, other: &Interval) -> Interval {
        if self.certainly_le(other) { other.clone() } else { self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn poly(c: &[f64]) -> Polynomial {
        Polynomial::new(c.iter().map(|&c| Interval::from_f64(c)).collect())
    }

    #[test]
    fn chebyshev_t5_reaches_one() {
        let t5 = poly(&[0.0, 5.0, 0.0, -20.0, 0.0, 16.0]);
        let one = Interval::from_int(1);
        let sup = t5.supremum(&-one.clone(), &one, &Interval::from_f64(1e-9));
        assert!(one.certainly_le(&sup.upper()), "{} is not an upper bound", sup.to_f64_up());
        assert!(sup.to_f64_up() < 1.0 + 2e-9);
        assert!(sup.to_f64_down() > 1.0 - 1e-6);
    }

    proptest! {
        #[test]
        fn the_supremum_is_never_exceeded(c in prop::collection::vec(-2.0..2.0f64, 1..8), at in 0.0..1.0f64) {
            let p = poly(&c);
            let (a, b) = (Interval::from_f64(-0.5), Interval::from_f64(0.75));
            let sup = p.supremum(&a, &b, &Interval::from_f64(1e-6));
            let v = Interval::from_f64(-0.5 + 1.25 * at);
            prop_assert!(p.at(&v).magnitude_lower().certainly_le(&sup.upper()));
        }

        #[test]
        fn shifting_moves_the_argument(c in prop::collection::vec(-2.0..2.0f64, 1..8), x in -1.0..1.0f64) {
            let p = poly(&c);
            let shifted = p.shift(&Interval::from_f64(x));
            let direct = p.at(&Interval::from_f64(x + 0.0));
            let diff = &shifted.at(&Interval::zero()) - &direct;
            prop_assert!(diff.magnitude().to_f64_up() < 1e-80);
        }
    }
}
