//! `exponential` terms of what the routine is given: w·(1 − e^(−x)) with x = (v − start)/scale, 0 before the start.
//! Of the time, where the routine is not given it, see [`super::warm_up`].

use fitter::terms::Exponential;

use super::Result;
use super::builder::Builder;
use super::exponent::{self, BITS};
use super::gaussian::limited;
use super::observed::Observed;
use crate::exact::Interval;

/// Subtracts the term from the result.
pub(super) fn subtract(
    b: &mut Builder,
    exponential: &Exponential,
    weight: &Interval,
    observed: &Observed,
) -> Result {
    if b.leaves_out(weight) {
        return Ok(());
    }
    let height = weight.magnitude().mul_pow2(b.sum.bits);
    let quarter = b.sum.tolerance.mul_pow2(-2);
    let limit = exponent::worth(&height, &quarter);
    let tail = exponent::tail(&limit, &height);
    let one = Interval::from_int(1);
    let zeta = observed.affine(
        &Interval::from_f64(exponential.start),
        &one.div(&(&Interval::from_f64(exponential.scale) * &limit)),
    );
    let slope = (&limit * &height).upper();
    let name = format!("since_{}", b.program.steps.len());
    let Some(word) = limited(b, &name, &zeta, 0, &quarter.div(&slope))? else {
        if one.certainly_le(&zeta.range().lower()) {
            b.add_constant(&(-weight.clone()).mul_pow2(b.sum.bits))?;
            b.add_error(&tail);
        }
        return Ok(());
    };
    let wanted = quarter.div(&height).mul_pow2(BITS);
    let left = exponent::exp_minus_of(b, &format!("{name}_left"), &word.exactly(), &limit, &wanted)?;
    b.add_scaled(&weight.mul_pow2(b.sum.bits + 32 - BITS), &left, "what is left of the way")?;
    b.add_constant(&(-weight.clone()).mul_pow2(b.sum.bits))?;
    b.add_error(&(&(&slope * &word.error.mul_pow2(-BITS)) + &tail));
    Ok(())
}
