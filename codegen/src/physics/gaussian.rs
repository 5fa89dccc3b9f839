//! `gaussian` terms: w·e^(−z²/2) with z = (v − centre)/width. Beyond some widths the bump is smaller than the
//! tolerance, so z is limited to ±Z, and with ζ = z/Z it is e^(−(Z²/2)·ζ²).

use fitter::terms::Gaussian;

use super::Result;
use super::builder::{Builder, Tracked};
use super::exponent::{self, BITS};
use super::observed::Observed;
use crate::exact::Interval;

/// Subtracts the term from the result.
pub(super) fn subtract(
    b: &mut Builder,
    gaussian: &Gaussian,
    weight: &Interval,
    observed: &Observed,
) -> Result {
    if b.leaves_out(weight) {
        return Ok(());
    }
    let height = weight.magnitude().mul_pow2(b.sum.bits);
    let quarter = b.sum.tolerance.mul_pow2(-2);
    // Z itself is any number; what lies beyond it is counted.
    let limit = (2.0 * exponent::worth(&height, &quarter).to_f64()).sqrt();
    let limit = Interval::from_f64(limit);
    let x = (&limit * &limit).mul_pow2(-1);
    let tail = exponent::tail(&x, &height);
    let zeta = observed.affine(
        &Interval::from_f64(gaussian.centre),
        &Interval::from_int(1).div(&(&Interval::from_f64(gaussian.width) * &limit)),
    );
    // The steepest slope of e^(−z²/2) is e^(−½) < 0.607, of it as a function of ζ Z times that.
    let slope = (&(&limit * &Interval::from_ratio(607, 1000)) * &height).upper();
    let number = b.program.steps.len();
    let Some(word) = limited(b, &format!("off_{number}"), &zeta, -1, &quarter.div(&slope))? else {
        b.add_error(&tail);
        return Ok(());
    };
    let exact = word.exactly();
    let none = Tracked::constant(&Interval::zero());
    let name = format!("square_{number}");
    let square = b.mul_add(&name, (&exact, &exact), (32 - BITS) as u32, &none, "")?;
    // A square is not negative, which an analysis by intervals does not see.
    let one = Interval::from_int(1);
    let square = b.clamp(&name, &square, (0, (1 << BITS) - 1), &one, "")?;
    let wanted = quarter.div(&height).mul_pow2(BITS);
    let bump = exponent::exp_minus_of(b, &format!("bump_{number}"), &square, &x, &wanted)?;
    b.add_scaled(&(-weight.clone()).mul_pow2(b.sum.bits + 32 - BITS), &bump, "a local bump")?;
    b.add_error(&(&(&slope * &word.error.mul_pow2(-BITS)) + &tail));
    Ok(())
}

/// The word of ζ·2^30 limited to `lowest`…1 (`lowest` −1 or 0), within about `tolerance` of 1; none where ζ lies
/// beyond either end throughout.
pub(super) fn limited(
    b: &mut Builder,
    name: &str,
    zeta: &Observed,
    lowest: i64,
    tolerance: &Interval,
) -> Result<Option<Tracked>> {
    let range = zeta.range();
    let one = Interval::from_int(1);
    let above = one.certainly_le(&range.lower());
    if above || range.upper().certainly_le(&Interval::from_int(lowest)) {
        return Ok(None);
    }
    let bits = zeta.bits().min(BITS - 1);
    let word = zeta.word(b, name, bits, &tolerance.mul_pow2(bits).lower())?;
    let end = 1i64 << bits;
    // Its upper end is one word short of 1.
    let word = b.clamp(name, &word, (lowest * end, end - 1), &one, "")?;
    let left = (BITS - bits) as u32;
    if left == 0 { Ok(Some(word)) } else { Ok(Some(b.shift_left(name, &word, left, "")?)) }
}
