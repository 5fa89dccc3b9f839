//! `rate` terms: w·dv/dt of what is observed, by the difference to the call before, calls coming at a
//! fixed period. The first call, which has none before it, has the rate 0.

use super::Result;
use super::builder::Builder;
use super::observed::Observed;
use crate::exact::Interval;
use crate::program::Operand;

/// Subtracts the term from the result; calls come every `period_s`.
pub(super) fn subtract(b: &mut Builder, weight: &Interval, observed: Observed, period_s: f64) -> Result {
    let (observed, _) = observed.centred();
    let number = b.program.state.len() + 1;
    let per_call = weight.div(&Interval::from_f64(period_s));
    let bits = observed.bits();
    let size = per_call.magnitude().hull(&Interval::pow2(-60)).upper();
    let tolerance = b.sum.tolerance.mul_pow2(bits - b.sum.bits - 1).div(&size).lower();
    let v = observed.word(b, &format!("now_{number}"), bits, &tolerance)?;
    if matches!(v.operand, Operand::Int(_)) {
        // Any two readings are within what a constant is off from each of them.
        b.add_error(&(&per_call.magnitude() * &v.error).mul_pow2(b.sum.bits - bits + 1));
        return Ok(());
    }
    let meaning = "the reading at the call before".to_string();
    let was = b.state(&format!("before_{number}"), meaning, &v, &v)?;
    b.keep(was.0, v.operand);
    let moved = b.sub(&format!("moved_{number}"), &v, &was.1)?;
    b.add_scaled(&(-per_call).mul_pow2(b.sum.bits - bits + 32), &moved, "the rate")
}
