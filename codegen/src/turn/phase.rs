//! Cosine and sine of a phase in integers, with a stated error: fast enough for every count of an 18-bit encoder,
//! and free of floating point.
//!
//! A phase is a word of 64 bits, the turn being 2⁶⁴. Its top 9 bits choose an entry of a table that is computed in
//! exact arithmetic; the rest is an angle of at most 2π·2⁻¹⁰, for which a few terms of the series do.

use std::sync::OnceLock;

use crate::exact::{Interval, cos_sin, pi};

/// One stands for 2⁻⁶² of the result.
pub(super) const ONE_LOG2: i64 = 62;

/// The result is within so many units of the exact cosine or sine. Every product below rounds by less than 1;
/// the angle is off by less than 2, both short series by less than 8 with what they leave out (δ⁸/8! < 2⁻⁷⁴), a
/// table entry by less than 1, and a result has two products: less than 2·(8 + 1 + 1) + 2 in all.
pub(super) const ERROR: i64 = 32;

const TABLE_LOG2: u32 = 9;

/// The table.
#[derive(Debug, Clone)]
pub(super) struct Circle {
    /// Cosine and sine at the middles of the parts.
    entries: Vec<(i64, i64)>,
    /// π/2.
    quarter: i64,
}

impl Circle {
    /// The table, computed once.
    pub(super) fn shared() -> &'static Circle {
        static CIRCLE: OnceLock<Circle> = OnceLock::new();
        CIRCLE.get_or_init(Circle::new)
    }

    fn new() -> Self {
        let parts = 1i64 << TABLE_LOG2;
        let fixed = |value: &Interval| value.mul_pow2(ONE_LOG2).round_to_i64().unwrap_or(0);
        let entry = |part: i64| {
            let middle = &pi() * &Interval::from_ratio(2 * part + 1, parts);
            let (cosine, sine) = cos_sin(&middle);
            (fixed(&cosine), fixed(&sine))
        };
        Circle { entries: (0..parts).map(entry).collect(), quarter: fixed(&pi().mul_pow2(-1)) }
    }

    /// Cosine and sine of a phase, each within [`ERROR`].
    pub(super) fn cos_sin(&self, phase: u64) -> (i64, i64) {
        let part = (phase >> (64 - TABLE_LOG2)) as usize;
        let within = (phase << TABLE_LOG2) as i128 >> TABLE_LOG2;
        let offset = (within - (1i128 << (63 - TABLE_LOG2))) as i64;
        // 2π·offset·2⁻⁶⁴ in units of 2⁻⁶² is offset·π/2.
        let angle = product(offset, self.quarter);
        let square = product(angle, angle);
        let one = 1i64 << ONE_LOG2;
        // cos δ = 1 − δ²/2(1 − δ²/12(1 − δ²/30)); sin δ = δ(1 − δ²/6(1 − δ²/20(1 − δ²/42))).
        let nested = |divisors: [i64; 3]| {
            divisors.iter().rev().fold(one, |sum, divisor| one - product(square, sum) / divisor)
        };
        let cosine = nested([2, 12, 30]);
        let sine = product(angle, nested([6, 20, 42]));
        let (c, s) = self.entries[part];
        (product(c, cosine) - product(s, sine), product(s, cosine) + product(c, sine))
    }
}

/// a·b in the units of both, rounded down.
pub(super) fn product(a: i64, b: i64) -> i64 {
    ((i128::from(a) * i128::from(b)) >> ONE_LOG2) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        /// Against the enclosures in exact arithmetic.
        #[test]
        fn the_error_is_kept(phase in prop_oneof![any::<u64>(), (0..512u64, -3i64..3).prop_map(|(j, d)| (j << 55).wrapping_add_signed(d))]) {
            let circle = Circle::shared();
            let (cosine, sine) = circle.cos_sin(phase);
            // In −½ … ½ of a turn, in two exact halves.
            let turns = &Interval::from_int((phase as i64) >> 32).mul_pow2(-32)
                + &Interval::from_int((phase & 0xffff_ffff) as i64).mul_pow2(-64);
            let exact = cos_sin(&(&pi() * &turns.mul_pow2(1)));
            for (found, exact) in [(cosine, exact.0), (sine, exact.1)] {
                let off = (&Interval::from_int(found) - &exact.mul_pow2(ONE_LOG2)).magnitude();
                prop_assert!(off.certainly_le(&Interval::from_int(ERROR)), "{} units", off.to_f64());
            }
        }
    }
}
