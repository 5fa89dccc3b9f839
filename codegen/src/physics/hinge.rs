//! `hinge` terms: w times how far what is observed lies beyond a threshold.

use fitter::terms::{Hinge, Side};

use super::Result;
use super::builder::Builder;
use super::observed::Observed;
use crate::exact::Interval;

/// Subtracts the term from the result.
pub(super) fn subtract(b: &mut Builder, hinge: &Hinge, weight: &Interval, observed: &Observed) -> Result {
    let side = if hinge.side == Side::Above { 1 } else { -1 };
    let beyond = observed.affine(&Interval::from_f64(hinge.threshold), &Interval::from_int(side));
    let range = beyond.range();
    if range.upper().certainly_le(&Interval::zero()) {
        // Nothing of the range lies beyond.
        return Ok(());
    }
    let bits = beyond.bits();
    let size = weight.magnitude().hull(&Interval::pow2(-60)).upper();
    let tolerance = b.sum.tolerance.mul_pow2(bits - b.sum.bits).div(&size).lower();
    let name = format!("beyond_{}", b.program.steps.len());
    let v = beyond.word(b, &name, bits, &tolerance)?;
    let v = b.clamp(&name, &v, (0, i32::MAX.into()), &Interval::zero(), "0 on the other side")?;
    b.add_scaled(&(-weight.clone()).mul_pow2(b.sum.bits - bits + 32), &v, "the slope beyond a threshold")
}
