//! Float inputs.

use super::{Asked, InputError, InputPlan, exponent_above, power_of_two};
use crate::exact::Interval;
use crate::program::{Op, Operand, Stage, Type};
use crate::reference::ReadingMap;

/// A float variable of magnitude 2^±UNSCALED_BITS or closer to 1 is used as it is.
const UNSCALED_BITS: i64 = 6;

/// The plan for a float.
pub(super) fn plan(asked: &Asked<'_>) -> Result<InputPlan, InputError> {
    let Asked { unit, from, to, format, clamped, .. } = *asked;
    let (first, last) = ends(from, to)?;
    let suffix = format!("_{}", unit.to_lowercase());
    let mut p = asked.program(&suffix, Type::F32, &format!("in {unit}"), Type::F32);
    let mut x = Operand::Step(p.reading);
    p.valid = (first.into(), last.into());
    if clamped {
        let clamp = Op::ClampF32 { a: x, lo: first, hi: last };
        x = p.push(Stage::Input, "limited", Type::F32, clamp, "the valid range");
        p.clamped = p.output();
    } else if format.is_fixed() {
        return Err(InputError::Unlimited);
    }
    let (a, b) = (f64::from(first), f64::from(last));
    let middle = (0.5 * (a + b)) as f32;
    let largest = |centre: f64| (a - centre).abs().max((b - centre).abs());
    let centre = if largest(middle.into()) * 2.0 <= largest(0.0) { middle } else { 0.0 };
    if centre != 0.0 {
        let from_middle = Op::Sub { a: x, b: Operand::Float(centre) };
        x = p.push(Stage::Input, "offset", Type::F32, from_middle, "from the middle of the range");
    }
    // |x| < 2^bits, with a margin for the rounding of the difference from the middle.
    let bits = exponent_above(largest(centre.into()) * (1.0 + power_of_two(-20)));
    let mut exponent = bits;
    if format.is_fixed() {
        let word = format.bits();
        let scale = Operand::Float(power_of_two(word - bits) as f32);
        let scaled = p.push(Stage::Input, "scaled", Type::F32, Op::MulF32 { a: x, b: scale }, "exact");
        p.push(Stage::Input, "x", Type::I32, Op::Truncate { a: scaled }, "");
        p.variable_exponent = word + 1;
        exponent = bits + 1;
    } else if bits.abs() > UNSCALED_BITS {
        let scale = Operand::Float(power_of_two(-bits) as f32);
        p.push(Stage::Input, "x", Type::F32, Op::MulF32 { a: x, b: scale }, "|x| ≤ 1, exact");
        p.variable_exponent = 0;
    } else {
        // Coefficients of x itself, unless its powers would leave the range of a float.
        p.variable_exponent = bits;
    }
    p.name_variable();
    let slope = Interval::pow2(exponent);
    let words = |end: f32| {
        let v = &(&Interval::from_f64(end.into()) - &Interval::from_f64(centre.into())).mul_pow2(-exponent);
        v.mul_pow2(p.variable_exponent)
    };
    Ok(InputPlan {
        word_from: words(first),
        word_to: words(last),
        reach: (words(first), words(last)),
        reading_word: (Interval::from_f64(centre.into()), slope.clone()),
        map: ReadingMap { offset: Interval::from_f64(centre.into()), slope },
        resolution: 0.0,
        program: p,
    })
}

/// The first and last float of the range.
fn ends(from: f64, to: f64) -> Result<(f32, f32), InputError> {
    let inward = |value: f64, wrong: fn(f64, f64) -> bool, step: fn(f32) -> f32| {
        let nearest = value as f32;
        if wrong(f64::from(nearest), value) { step(nearest) } else { nearest }
    };
    let first = inward(from, |f, v| f < v, f32::next_up);
    let last = inward(to, |f, v| f > v, f32::next_down);
    if !(first.is_finite()
        && last.is_finite()
        && f64::from(first).abs().max(f64::from(last).abs()) < 2f64.powi(60))
    {
        return Err(InputError::BeyondFloat(from, to));
    }
    if last <= first {
        return Err(InputError::NoResolution(from, to));
    }
    Ok((first, last))
}
