//! `lag` terms: w·(v_L − mean), τ dv_L/dt = v − v_L, v taken as a straight line between two calls:
//! v_L' = v_L + κ₀(v₋ − v_L) + κ₁(v − v_L), with a = e^(−T/τ), κ₁ = 1 − (1 − a)τ/T, κ₀ = 1 − a − κ₁, for calls at
//! the period T, v₋ being the input of the call before.
//!
//! The state is a word of 64 bits, so that a slow lag moves at all. What it is off obeys
//! e ← a·e + (1 − a)·(1 + e_v) + what the rounded κ leave, so that it stays within 1 + e_v + |δκ|·width/(1 − a)
//! words however long it runs: that is its limit cycle.

use fitter::terms::Lag;

use super::Result;
use super::builder::{Builder, Tracked};
use super::observed::Observed;
use crate::exact::{Interval, exp_minus};

/// The input, less the middle of its range, is taken to words of at most 2^FRACTION.
const FRACTION: i64 = 23;
/// κ has at most so many bits more than 31: the state is a word of 2^(FRACTION + 1 + 31 + MOST) at most.
const MOST: i64 = 7;

/// Subtracts the term from the result; calls come every `period_s`.
pub(super) fn subtract(
    b: &mut Builder,
    lag: &Lag,
    weight: &Interval,
    observed: &Observed,
    period_s: f64,
) -> Result {
    let one = Interval::from_int(1);
    let ratio = Interval::from_f64(period_s).div(&Interval::from_f64(lag.time_constant_s));
    let gone = &one - &exp_minus(&ratio);
    let last = &one - &gone.div(&ratio);
    let before = &gone - &last;
    let fits = |bits: &i64| gone.mul_pow2(*bits).certainly_le(&Interval::from_int(i32::MAX.into()));
    let bits = (31..=31 + MOST).rev().find(fits).unwrap_or(30);
    let [k0, k1] = [&before, &last].map(|k| Tracked::constant(&k.mul_pow2(bits)));
    let number = b.program.state.len() + 1;

    let middle = observed.range().midpoint();
    let centred = observed.affine(&middle, &one);
    let scale = centred.bits() - 30 + FRACTION;
    let unit = one.mul_pow2(-scale);
    let now = centred.word(b, &format!("now_{number}"), scale, &one)?;
    let start = match lag.initial {
        None => now.clone(),
        Some(at) => Tracked::constant(&(&Interval::from_f64(at) - &middle).mul_pow2(scale)),
    };
    let meaning = format!("`{}` at the call before", lag.observable);
    let was = b.state(&format!("before_{number}"), meaning, &now, &now)?;
    b.keep(was.0, now.operand);
    // Two words wider than what the input can be: the lag's own floor.
    let range = &now.range.hull(&start.range) + &Interval::from_int(2).symmetric();
    let width = (&range.upper() - &range.lower()).upper();
    let limit = (&(&k0.error + &k1.error) * &width).div(&gone.mul_pow2(bits));
    let error = (&(&now.error + &one) + &limit).hull(&start.error).magnitude();
    let name = format!("lag_{number}");
    let begin = b.mul_add_wide(&format!("{name}_start"), (&start, 1i64 << bits), None)?;
    let meaning = format!("the lagged `{}`, of which 2^-{} is a word", lag.observable, bits);
    let (index, state) = b.wide_state(&name, meaning, begin.operand, range.mul_pow2(bits))?;
    let held = b.high(&format!("held_{number}"), &state, bits as u32, range.clone(), &error)?;
    let e0 = b.sub(&format!("e0_{number}"), &was.1, &held)?;
    let e1 = b.sub(&format!("e1_{number}"), &now, &held)?;
    let word = |k: &Tracked| k.range.round_to_i64().unwrap_or(0);
    let half = b.mul_add_wide(&format!("{name}_half"), (&e0, word(&k0)), Some(&state))?;
    let next = b.mul_add_wide(&format!("{name}_next"), (&e1, word(&k1)), Some(&half))?;
    b.keep(index, next.operand);
    let lagged = b.high(&format!("lagged_{number}"), &next, bits as u32, range, &error)?;

    // −w·(middle + v_L − mean).
    let factor = (-(weight * &unit)).mul_pow2(b.sum.bits + 32);
    b.add_scaled(&factor, &lagged, "the lag")?;
    let constant = (weight * &(&Interval::from_f64(lag.mean) - &middle)).mul_pow2(b.sum.bits);
    b.add_constant(&constant)
}
