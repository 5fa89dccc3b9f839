//! The exponential function, enclosed.

use crate::exact::Interval;

/// e^−x for x ≥ 0, to some 2⁻¹⁰⁰ beyond the width of x: the alternating series of x/2^k ≤ ½, squared k times.
pub fn exp_minus(x: &Interval) -> Interval {
    const TERMS: i64 = 30;
    let one = Interval::from_int(1);
    let halvings = x.upper().log2_floor().map_or(0, |e| (e + 2).max(0));
    let small = x.mul_pow2(-halvings);
    // The terms fall by half at least: the first one left out bounds the rest.
    let rest = (1..=TERMS).fold(one.clone(), |term, k| (&term * &small.upper()).div(&Interval::from_int(k)));
    let sum =
        (1..TERMS).rev().fold(one.clone(), |sum, k| &one - &(&sum * &small).div(&Interval::from_int(k)));
    let start = &sum + &rest.upper().symmetric();
    (0..halvings).fold(start, |power, _| &power * &power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_are_enclosed() {
        for x in [0.0, 1e-7, 0.1, 1.0, 5.0, 40.0f64] {
            let found = exp_minus(&Interval::from_f64(x));
            assert!((found.to_f64() / (-x).exp() - 1.0).abs() < 1e-14, "{x}");
        }
    }
}
