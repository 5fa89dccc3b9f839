//! `play` terms: Σ wⱼ·(v − pⱼ), each pⱼ following the observable v at a distance of at most rⱼ. With
//! d = v − p this is d ← limit(v − p, −r, r), p ← v − d. Nothing of that is rounded: only v is.
//!
//! The play operator does not expand distances (Brokate and Sprekels, "Hysteresis and Phase Transitions", 1996,
//! proposition 2.3.9): if every v is known to within e, r to within e_r and the initial state to within e₀, then
//! every p is within max(e + e_r, e₀), however long the history.

use fitter::terms::{Element, Play};

use super::builder::{Builder, Tracked};
use super::observed::Observed;
use super::{PhysicsError, Result};
use crate::exact::Interval;
use crate::program::Operand;

/// Bits of an element's half-width at most: it is ±2^n, so that its limits are one instruction, and the word of
/// the observable is scaled to that.
const FINEST: i64 = 28;

/// Subtracts the term from the result.
pub(super) fn subtract(b: &mut Builder, play: &Play, weights: &[Interval], observed: Observed) -> Result {
    let (observed, middle) = observed.centred();
    // v as a word of 2²⁹…2³⁰ at most; what it is off counts twice for every element.
    let bits = observed.bits();
    let all = weights.iter().fold(Interval::from_f64(1e-6), |sum, w| &sum + &w.magnitude()).upper();
    let tolerance = b.sum.tolerance.mul_pow2(bits - b.sum.bits - 1).div(&all);
    let name = format!("follow_{}", b.program.state.len() + 1);
    let v = observed.word(b, &name, bits, &tolerance.lower())?;
    for (element, weight) in play.elements.iter().zip(weights) {
        let largest = weight * &Interval::from_f64(element.half_width);
        // Where any observable is near enough, the play has nothing to follow.
        if matches!(v.operand, Operand::Int(_)) {
            b.add_error(&largest.magnitude().mul_pow2(b.sum.bits));
            continue;
        }
        if b.leaves_out(&largest) {
            continue;
        }
        follow(b, (&v, bits, &middle), element, weight)?;
    }
    Ok(())
}

/// One element of it; the observable less `middle` is a word v·2^bits.
fn follow(
    b: &mut Builder,
    (v, bits, middle): (&Tracked, i64, &Interval),
    element: &Element,
    weight: &Interval,
) -> Result {
    let narrow = || PhysicsError::NarrowPlay(element.half_width);
    let r = Interval::from_f64(element.half_width);
    let number = b.program.state.len() + 1;
    // The observable in words of which r is 2^n: not more than half of v's.
    let scale = |n: i64| Interval::pow2(n - bits).div(&r);
    let largest = Interval::from_int(i32::MAX.into()).mul_pow2(-32);
    let n = (1..=FINEST).rev().find(|n| scale(*n).certainly_le(&largest)).ok_or_else(narrow)?;
    let (v_name, p_name, d_name) = (format!("v{number}"), format!("play_{number}"), format!("d{number}"));
    let none = Tracked::constant(&Interval::zero());
    let v = b.mul_add(&v_name, (&Tracked::constant(&scale(n).mul_pow2(32)), v), 0, &none, "")?;
    let start = match element.initial {
        None => v.clone(),
        Some(at) => Tracked::constant(&(&(&Interval::from_f64(at) - middle) * &scale(n)).mul_pow2(bits)),
    };
    // The upper limit is one word short of r.
    let one = Interval::from_int(1);
    let error = (&v.error + &one).hull(&start.error).magnitude();
    let meaning = format!("a play of half-width {}, in 2^-{n} of that", element.half_width);
    let held = Tracked { range: v.range.hull(&start.range), error, ..start.clone() };
    let (index, p) = b.state(&p_name, meaning, &start, &held)?;
    let distance = b.sub(&d_name, &v, &p)?;
    let limit = 1i64 << n;
    let d = b.clamp(&d_name, &distance, (-limit, limit - 1), &one, "")?;
    let next = b.sub(&format!("{p_name}_next"), &v, &d)?;
    b.keep(index, next.operand);
    // −w·(v − p) in words of the sum: d·r·2^−n·2^bits.
    let factor = (-(weight * &r)).mul_pow2(b.sum.bits - n + 32);
    b.add_scaled(&factor, &d, "")
}
