//! `exponential` terms of the time since the routine began: w·(1 − d), d = e^(−(t − start)/τ), which from call to
//! call becomes d' = d − κ·d with κ = 1 − e^(−T/τ), T being the period of the calls.
//!
//! The state is d as a word S of 64 bits, 2^(F + bits), S' = S − κ'·⌊S·2^−bits⌋. What it is off obeys
//! |e'| ≤ (1 − κ')·|e| + |κ' − κ|·d + κ', so that it stays within 1 + |κ' − κ|·2^F/κ' of 2^F however long the routine
//! runs. F balances the two. S never grows and never falls below 0: where ⌊S·2^−bits⌋ is 0 it stands still.

use fitter::terms::Exponential;

use super::builder::{Builder, Tracked};
use super::{PhysicsError, Result};
use crate::exact::{Interval, exp_minus};

/// The state's bits.
const WORD: i64 = 62;

/// Subtracts the term from the result; calls come every `period_s`, the first at the time 0.
pub(super) fn subtract(
    b: &mut Builder,
    exponential: &Exponential,
    weight: &Interval,
    period_s: f64,
) -> Result {
    let one = Interval::from_int(1);
    let scale = Interval::from_f64(exponential.scale);
    let gone = &one - &exp_minus(&Interval::from_f64(period_s).div(&scale));
    let largest = Interval::from_int(i32::MAX.into());
    // κ as a word, and what d is off in the end, relative to 1, with F bits.
    let plan = |fraction: i64| {
        let fits = |bits: &i64| gone.mul_pow2(*bits).certainly_le(&largest);
        let bits = (0..=WORD - fraction).rev().find(fits)?;
        let kappa = Tracked::constant(&gone.mul_pow2(bits));
        let step = kappa.range.lower();
        one.certainly_le(&step).then(|| {
            let limit = kappa.error.mul_pow2(fraction).div(&step);
            let error = &Interval::from_int(1) + &limit;
            (bits, kappa, error.upper(), fraction)
        })
    };
    let off = |p: &(i64, Tracked, Interval, i64)| p.2.to_f64_up() * 2f64.powi(-(p.3 as i32));
    let plans = (8..=29).filter_map(plan).min_by(|a, b| off(a).total_cmp(&off(b)));
    let (bits, kappa, limit, fraction) = plans.ok_or(PhysicsError::TooLarge)?;

    let number = b.program.state.len() + 1;
    let start = exp_minus(&Interval::from_f64(-exponential.start).div(&scale));
    let start = Tracked::constant(&start.mul_pow2(fraction));
    let error = limit.hull(&start.error).magnitude();
    let name = format!("left_{number}");
    let begin = b.mul_add_wide(&format!("{name}_start"), (&start, 1i64 << bits), None)?;
    let meaning = format!("what is left of a warm-up, of which 2^-{} is a word", bits + fraction);
    let whole = Interval::zero().hull(&start.range);
    let (index, state) = b.wide_state(&name, meaning, begin.operand, whole.mul_pow2(bits))?;
    let held = b.high(&format!("held_{number}"), &state, bits as u32, whole, &error)?;
    let by = -kappa.range.round_to_i64().unwrap_or(0);
    let next = b.mul_add_wide(&format!("{name}_next"), (&held, by), Some(&state))?;
    b.keep(index, next.operand);

    b.add_scaled(&weight.mul_pow2(b.sum.bits - fraction + 32), &held, "the warm-up")?;
    b.add_constant(&(-weight.clone()).mul_pow2(b.sum.bits))
}
