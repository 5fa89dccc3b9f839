//! The function that is generated, enclosed: the corrected angle of Eq. 13,
//! atan(s/d) − d/(s²+d²)·Σaᵢsⁱ, as a polynomial with a certified remainder.
//!
//! The coefficients of the file are taken as the exact rational numbers that they are as `f64`. With
//! u = s/d both atan u = Σ(−1)ᵏu²ᵏ⁺¹/(2k+1) and 1/(1+u²) = Σ(−1)ᵏu²ᵏ alternate for |u| < 1, so each
//! remainder is at most the first term left out.

use fitter::error_model::{ErrorModel, Sensor};

use crate::exact::{Interval, Polynomial};

/// How far an angle may go: |s| ≤ d/2, ±26.6°. No pair of probes measures further.
const LARGEST_TANGENT: f64 = 0.5;

/// What the series leave out is far below any output format: 2⁻⁸⁰ of the output's unit.
const SERIES_TOLERANCE_LOG2: i64 = -80;

/// reading = offset + slope·v: how the normalised variable v of a routine, |v| ≤ 1, stands for the reading
/// (s in millimetres, or a direct sensor's reading in its unit).
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingMap {
    /// The reading at v = 0.
    pub offset: Interval,
    /// The change of the reading by one unit of v.
    pub slope: Interval,
}

impl ReadingMap {
    /// The reading that `v` stands for.
    pub fn reading(&self, v: &Interval) -> Interval {
        &self.offset + &(&self.slope * v)
    }
}

/// The corrected angle in radians (direct sensor: corrected reading in its unit) as a function of v.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// A polynomial of v that is within `remainder` of the function over the range.
    pub polynomial: Polynomial,
    /// The largest distance of the polynomial from the function (a point).
    pub remainder: Interval,
}

/// The range leaves what the series and the sensor can do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the range reaches s = {reading_mm} mm, which is more than half of the probe distance d = {probe_distance_mm} mm \
     (±26.6°): check probe_distance_mm, or narrow the range"
)]
pub struct TooSteep {
    /// The end of the range in millimetres.
    pub reading_mm: f64,
    /// d in millimetres.
    pub probe_distance_mm: f64,
}

fitter::errors!(plain TooSteep);

impl Reference {
    /// Encloses the corrected angle of `model` for v from `from` to `to` (points), |v| ≤ 1.
    ///
    /// # Errors
    /// [`TooSteep`] where |s| exceeds d/2.
    pub fn new(
        model: &ErrorModel,
        map: &ReadingMap,
        from: &Interval,
        to: &Interval,
    ) -> Result<Self, TooSteep> {
        let reading = Polynomial::linear(map.offset.clone(), map.slope.clone());
        let centred = reading.sub(&Polynomial::constant(Interval::from_f64(model.centre)));
        let zero = Polynomial::constant(Interval::zero());
        let error_polynomial = model
            .coefficients
            .iter()
            .rev()
            .fold(zero, |sum, a| sum.mul(&centred).add(&Polynomial::constant(Interval::from_f64(*a))));
        match model.sensor {
            Sensor::Direct { .. } => {
                Ok(Reference { polynomial: reading.sub(&error_polynomial), remainder: Interval::zero() })
            }
            Sensor::EddyCurrentPair { probe_distance_mm: d_mm, .. } => {
                let d = Interval::from_f64(d_mm);
                let ends = map.reading(from).hull(&map.reading(to)).magnitude();
                let u_max = ends.div(&d).upper();
                if !u_max.certainly_le(&Interval::from_f64(LARGEST_TANGENT)) {
                    return Err(TooSteep { reading_mm: ends.to_f64(), probe_distance_mm: d_mm });
                }
                let u = Polynomial::new(reading.coefficients().iter().map(|c| c.div(&d)).collect());
                Ok(pair(&u, &u_max, &error_polynomial, &d, from.hull(to).magnitude()))
            }
        }
    }

    /// An enclosure of the function at `v` (a point of the range).
    pub fn at(&self, v: &Interval) -> Interval {
        &self.polynomial.at(v) + &self.remainder.symmetric()
    }
}

/// atan u − (1/d)/(1+u²)·error_polynomial, with |u| ≤ `u_max` and |v| ≤ `v_max`.
fn pair(
    u: &Polynomial,
    u_max: &Interval,
    error_polynomial: &Polynomial,
    d: &Interval,
    v_max: Interval,
) -> Reference {
    let tolerance = Interval::pow2(SERIES_TOLERANCE_LOG2);
    let square = u.mul(u);
    let error_max = error_polynomial.range_around_zero(&v_max).magnitude().div(d).upper();
    let scale = error_max.hull(&Interval::from_int(1)).magnitude();

    let mut terms = 1;
    let mut left_out = (&square_of(u_max) * &scale).upper();
    while !left_out.certainly_le(&tolerance) {
        left_out = (&left_out * &square_of(u_max)).upper();
        terms += 1;
    }

    // Both series by Horner in u²: atan u = u·Σ(−1)ᵏu²ᵏ/(2k+1), 1/(1+u²) = Σ(−1)ᵏu²ᵏ, k < terms.
    let series = |coefficient: &dyn Fn(i64) -> Interval| {
        (0..terms).rev().fold(Polynomial::constant(Interval::zero()), |sum, k| {
            let c = coefficient(k);
            sum.mul(&square).add(&Polynomial::constant(if k % 2 == 0 { c } else { -c }))
        })
    };
    let atan = u.mul(&series(&|k| Interval::from_ratio(1, 2 * k + 1)));
    let error = series(&|_| Interval::from_int(1)).mul(error_polynomial).scale(&Interval::from_int(1).div(d));
    let mut polynomial = atan.sub(&error);
    let dropped = polynomial.truncate(&v_max, &tolerance);
    // Each series leaves out at most |u|^(2·terms), times the error polynomial's largest value.
    let remainder = (&(&left_out + &left_out) + &dropped).upper();
    Reference { polynomial, remainder }
}

fn square_of(x: &Interval) -> Interval {
    (x * x).upper()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_model;
    use proptest::prelude::*;

    #[test]
    fn too_steep_is_refused() {
        let map = ReadingMap { offset: Interval::zero(), slope: Interval::from_int(8) };
        let one = Interval::from_int(1);
        assert!(Reference::new(&paper_model(), &map, &-one.clone(), &one).is_err());
    }

    proptest! {
        /// The enclosure holds the f64 evaluation of Eq. 13 to what f64 itself rounds.
        #[test]
        fn the_enclosure_holds_eq_13(s in -0.5..0.5f64) {
            let map = ReadingMap { offset: Interval::zero(), slope: Interval::from_int(1) };
            let half = Interval::from_f64(0.5);
            let reference = Reference::new(&paper_model(), &map, &-half.clone(), &half).unwrap();
            let enclosed = reference.at(&Interval::from_f64(s));
            prop_assert!(reference.remainder.to_f64_up() < 1e-23);
            prop_assert!((enclosed.to_f64() - paper_model().corrected(s)).abs() < 1e-16);
        }
    }
}
