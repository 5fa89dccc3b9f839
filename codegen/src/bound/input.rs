//! What the steps from the arguments to the variable round.

use super::value::half_ulp;
use crate::exact::Interval;
use crate::input::InputPlan;
use crate::program::{Op, Operand, Program, Type};

/// The largest distance, in v, between the variable and the exact reading, where the variable's word lies in
/// `words`: every step of the input is affine in the reading, so only roundings add up.
pub(super) fn input_error(program: &Program, plan: &InputPlan, words: &Interval) -> Interval {
    // Magnitudes are taken a little wider, so that the binade of the exact value is never missed.
    let v = words.mul_pow2(-program.variable_exponent);
    let v = &v + &Interval::pow2(-16).symmetric();
    let affine = |word: &(Interval, Interval)| &word.0 + &(&word.1 * &v);
    let mut exact = plan.reading_word.clone();
    let mut error = Interval::zero();
    for step in &program.steps[program.reading..=program.variable] {
        let half_ulp = |value: &Interval| half_ulp(value);
        match &step.op {
            Op::Sub { b: Operand::Step(_), .. } if step.ty == Type::F32 => error = half_ulp(&affine(&exact)),
            Op::Sub { b: Operand::Float(c), .. } => {
                exact.0 = &exact.0 - &Interval::from_f64((*c).into());
                error = (&error + &half_ulp(&affine(&exact))).upper();
            }
            Op::Sub { b: Operand::Int(c), .. } => exact.0 = &exact.0 - &Interval::from_int(*c),
            Op::ShiftLeft { by, .. } => {
                let by = i64::from(*by);
                exact = (exact.0.mul_pow2(by), exact.1.mul_pow2(by));
                error = error.mul_pow2(by);
            }
            Op::MulF32 { b: Operand::Float(c), .. } => {
                let c = Interval::from_f64((*c).into());
                exact = (&exact.0 * &c, &exact.1 * &c);
                error = (&error * &c.magnitude()).upper();
                // By a power of two: exact but for what falls below the smallest float.
                error = (&error + &Interval::pow2(-150)).upper();
            }
            Op::Truncate { .. } => error = (&error + &Interval::from_int(1)).upper(),
            Op::ShiftRight { add, by, .. } => {
                // With half of what is shifted out added, to nearest; otherwise downward.
                let to_nearest = *add == 1 << (by - 1);
                let by = -i64::from(*by);
                exact = (exact.0.mul_pow2(by), exact.1.mul_pow2(by));
                error = (&error.mul_pow2(by) + &Interval::pow2(-i64::from(to_nearest))).upper();
            }
            Op::ToF32 { .. } => {
                let value = affine(&exact);
                if !value.magnitude().certainly_le(&Interval::from_int(1 << 24)) {
                    error = (&error + &half_ulp(&value)).upper();
                }
            }
            // A reading between the end of the range and the last float inside rounds to that float or to the
            // next, which is limited to it: then the error is up to a whole unit in the last place.
            Op::ClampF32 { .. }
                if words.lower().certainly_le(&plan.word_from.upper())
                    || plan.word_to.lower().certainly_le(&words.upper()) =>
            {
                error = (&error + &error).upper();
            }
            Op::Input { .. } | Op::Sub { .. } | Op::Clamp { .. } | Op::ClampF32 { .. } => {}
            other => unreachable!("{other:?} is no step of an input"),
        }
    }
    error.mul_pow2(-program.variable_exponent)
}
