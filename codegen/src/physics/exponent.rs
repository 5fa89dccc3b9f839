//! e^−x of a word x, by which bumps and saturating terms are made: e^−x = (e^(−x/2^k))^(2^k), a polynomial on the
//! first unit of x/2^k and k squarings. What the squarings enlarge is counted where each is appended.

use super::Result;
use super::builder::{Builder, Tracked};
use super::shape::{Shape, best_within, horner};
use crate::exact::{Interval, Polynomial, exp_minus};

/// Terms of the series: what is left out is below 2⁻⁸⁰.
const TERMS: i64 = 25;
/// More squarings of squares than Gappa follows: then their account is taken as given there.
const MOST_SQUARINGS: i64 = 2;
/// A word of the result, and of the variable, is so many bits of 1.
pub(super) const BITS: i64 = 30;

/// Appends the steps to e^(−x·q), where q·2^30 is a word from 0 to 2^30 that is taken as exact, within some
/// `tolerance` words of 2⁻³⁰ where the format allows.
pub(super) fn exp_minus_of(
    b: &mut Builder,
    name: &str,
    q: &Tracked,
    x: &Interval,
    tolerance: &Interval,
) -> Result<Tracked> {
    let one = Interval::from_int(1);
    let squarings = x.upper().log2_floor().map_or(0, |e| (e + 1).max(0));
    let y = x.mul_pow2(-squarings);
    // Alternating for 0 ≤ q ≤ 1 and y < 1; the words may lie a trace outside.
    let mut term = one.clone();
    let mut series = Vec::new();
    for n in 0..TERMS {
        series.push(term.clone());
        term = -(&term * &y).div(&Interval::from_int(n + 1));
    }
    let shape = Shape { polynomial: Polynomial::new(series), remainder: term.magnitude().mul_pow2(1) };
    let ends = (-one.mul_pow2(-20), &one + &one.mul_pow2(-20));
    let wanted = tolerance.mul_pow2(-squarings - 1 - BITS);
    let (best, distance) = best_within(&shape, &ends, &wanted.lower());
    let mut power = horner(b, name, &best, BITS, (q, BITS), "")?;
    power.error = (&power.error + &distance.mul_pow2(BITS)).upper();
    let zero = Tracked::constant(&Interval::zero());
    for _ in 0..squarings {
        power = b.mul_add(name, (&power, &power), (32 - BITS) as u32, &zero, "")?;
    }
    if squarings > MOST_SQUARINGS {
        b.known_otherwise();
    }
    // The function itself stays within 0…1.
    let reach = one.mul_pow2(BITS).hull(&Interval::zero());
    let near = &reach + &power.error.symmetric();
    if near.inside(&power.range) {
        power.range = near;
    }
    Ok(power)
}

/// How many units of x are worth evaluating: beyond, e^−x·`size` stays below `tolerance`. Any answer would do, for
/// what lies beyond is counted.
pub(super) fn worth(size: &Interval, tolerance: &Interval) -> Interval {
    let ratio = size.to_f64_up() / tolerance.to_f64_down().max(f64::MIN_POSITIVE);
    Interval::from_f64((ratio * 4.0).max(2.0).ln().ceil().clamp(1.0, 40.0))
}

/// The largest e^−x·`size` beyond `x`.
pub(super) fn tail(x: &Interval, size: &Interval) -> Interval {
    (&exp_minus(x) * size).magnitude().upper()
}
