//! π, arcseconds, sine and cosine, enclosed.

use crate::exact::Interval;

/// π = 3.14159265358979311600 + 1.2246467991473532e-16 − 2.99…e-33: two `f64`, and what they leave out.
pub fn pi() -> Interval {
    let two = &Interval::from_f64(std::f64::consts::PI) + &Interval::from_f64(1.224_646_799_147_353_2e-16);
    &two + &Interval::from_f64(-3.1e-33).hull(&Interval::zero())
}

/// Arcseconds in a radian, 648 000/π.
pub fn arcsec_per_rad() -> Interval {
    Interval::from_int(648_000).div(&pi())
}

/// cos x and sin x for |x| ≤ 8, to some 2⁻¹⁰⁰ beyond the width of x: their series alternate and, from the
/// eighth term on, fall.
pub fn cos_sin(x: &Interval) -> (Interval, Interval) {
    const TERMS: i64 = 30;
    let square = x * x;
    let series = |first: i64| {
        // Σ (−1)ᵏ x²ᵏ/(2k + first)!·first!, by Horner's scheme; the first term left out bounds the rest.
        let term = |k: i64| Interval::from_int((2 * k + first) * (2 * k + first - 1));
        let mut rest = Interval::from_int(1);
        for k in 1..=TERMS {
            rest = (&rest * &square.magnitude()).div(&term(k)).upper();
        }
        let one = Interval::from_int(1);
        let sum = (1..TERMS).rev().fold(one.clone(), |sum, k| &one - &(&sum * &square).div(&term(k)));
        &sum + &rest.symmetric()
    };
    (series(0), x * &series(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_are_enclosed() {
        assert!((pi().to_f64_up() - pi().to_f64_down()).abs() < 1e-15);
        for x in [-7.5, -3.0, -0.1, 0.0, 1.0, 2.5, 6.3] {
            let (cosine, sine) = cos_sin(&Interval::from_f64(x));
            assert!((cosine.to_f64() - x.cos()).abs() < 1e-15);
            assert!((sine.to_f64() - x.sin()).abs() < 1e-15);
            // cos² + sin² = 1 within what is claimed.
            let one = &(&cosine * &cosine) + &(&sine * &sine);
            let off = (&one - &Interval::from_int(1)).magnitude();
            assert!(off.certainly_le(&Interval::pow2(-90)), "{x}");
        }
        // sin π lies around zero.
        let (_, sine) = cos_sin(&pi());
        assert!(sine.lower().certainly_le(&Interval::zero()) && Interval::zero().certainly_le(&sine.upper()));
    }
}
