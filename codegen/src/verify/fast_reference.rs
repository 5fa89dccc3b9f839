//! What compiled outputs are held against: the reference as a polynomial that plain `f64` arithmetic
//! evaluates, fast, with a rigorous bound of everything that this evaluation leaves out or rounds.
//!
//! In the unit of the output word the harness computes, for a reading r limited to the valid range,
//! v = (r − centre)·scale and Σcₖvᵏ by Horner's scheme, every operation rounded once to `f64`. Its distance
//! from the exact function is at most the sum of
//! - what the reference's series leave out and the higher terms dropped here,
//! - |cₖ − f64(cₖ)|·|v|ᵏ for every coefficient,
//! - half an ulp of every product and sum, each carried on by a factor |v| a step, and
//! - the reference's slope times what v itself was rounded.

use crate::exact::{Interval, Polynomial};
use crate::input::InputPlan;
use crate::program::{Program, Type};
use crate::reference::Reference;
use crate::routine::Routine;

/// Terms are dropped while their sum stays below this part of the routine's bound.
const DROPPED_LOG2: i64 = -26;
/// Half an ulp of an `f64`, relative to the result.
const UNIT_ROUNDOFF_LOG2: i64 = -53;

/// A fast reference and how far it may be off.
#[derive(Debug, Clone, PartialEq)]
pub struct FastReference {
    /// c₀, c₁, …: the function of v, in output words.
    pub coefficients: Vec<f64>,
    /// The reading, in its own words, at which v = 0.
    pub centre: f64,
    /// v by one word of the reading.
    pub scale: f64,
    /// Smallest and largest valid reading, in its own words.
    pub range: (f64, f64),
    /// Rigorous upper bound of |fast reference − exact function| over the range, in output words.
    pub error: f64,
}

impl FastReference {
    /// The fast reference of a designed routine.
    pub fn of(routine: &Routine) -> Self {
        let Routine { design, plan, reference, .. } = routine;
        FastReference::new(&design.program, plan, reference, &design.unit, design.bound.total)
    }

    /// Of a program that is within `bound` of a reference; `unit` is what one output word stands for.
    pub(crate) fn new(
        program: &Program,
        plan: &InputPlan,
        reference: &Reference,
        unit: &Interval,
        bound: f64,
    ) -> Self {
        let one = Interval::from_int(1);
        let word = one.div(unit);
        let (offset, step) = (&plan.reading_word.0, &plan.reading_word.1);
        let range = program.valid;
        let (centre, scale) = (offset.to_f64(), one.div(step).to_f64());
        let reach = {
            let from = &(&Interval::from_f64(range.0) - offset).div(step);
            let to = &(&Interval::from_f64(range.1) - offset).div(step);
            // A little wider: the computed v is within its rounding of the exact one.
            &from.hull(to).magnitude() * &(&one + &one.mul_pow2(UNIT_ROUNDOFF_LOG2 + 4))
        };
        let radius = reach.upper();

        let mut exact = reference.polynomial.scale(&word);
        let tolerance = (&Interval::from_f64(bound) * &word).mul_pow2(DROPPED_LOG2);
        let dropped = exact.truncate(&radius, &tolerance.upper());
        let coefficients: Vec<f64> = exact.coefficients().iter().map(Interval::to_f64).collect();

        let mut error = &dropped + &(&reference.remainder * &word).upper();
        let mut power = one.clone();
        for (c, rounded) in exact.coefficients().iter().zip(&coefficients) {
            error = &error + &(&(c - &Interval::from_f64(*rounded)).magnitude() * &power).upper();
            power = (&power * &radius).upper();
        }
        error = &error + &horner_rounding(&coefficients, &radius);
        error = &error + &variable_rounding(program, plan, &exact, &radius);
        FastReference { coefficients, centre, scale, range, error: error.to_f64_up() }
    }

    /// The value for a reading, exactly as the harnesses compute it.
    pub fn at(&self, reading: f64) -> f64 {
        let (lo, hi) = self.range;
        // Written so that a NaN gives the lower end, as the routines do.
        let limited = if reading >= lo { if reading > hi { hi } else { reading } } else { lo };
        let v = (limited - self.centre) * self.scale;
        self.coefficients.iter().rev().copied().reduce(|y, c| y * v + c).unwrap_or(0.0)
    }
}

/// Rounding errors of Horner's scheme in `f64` for |v| ≤ `radius`, from magnitudes alone.
fn horner_rounding(coefficients: &[f64], radius: &Interval) -> Interval {
    let u = |x: &Interval| {
        let subnormal = Interval::pow2(-310);
        (&x.mul_pow2(UNIT_ROUNDOFF_LOG2) + &subnormal).upper()
    };
    let magnitude = |c: f64| Interval::from_f64(c).magnitude();
    let Some((last, rest)) = coefficients.split_last() else { return Interval::zero() };
    let (mut largest, mut error) = (magnitude(*last), Interval::zero());
    for c in rest.iter().rev() {
        let product = (&largest * radius).upper();
        let product_rounding = u(&product);
        let sum = (&(&product + &product_rounding) + &magnitude(*c)).upper();
        let sum_rounding = u(&sum);
        error = (&(&(&error * radius) + &product_rounding) + &sum_rounding).upper();
        largest = (&sum + &sum_rounding).upper();
    }
    error
}

/// What the rounding of v can shift the value: nothing where the readings are integers.
fn variable_rounding(program: &Program, plan: &InputPlan, exact: &Polynomial, radius: &Interval) -> Interval {
    let (offset, step) = (&plan.reading_word.0, &plan.reading_word.1);
    let range = program.valid;
    let one = Interval::from_int(1);
    let centre_exact = Interval::from_f64(offset.to_f64()) == *offset;
    let scale_exact = &Interval::from_f64(one.div(step).to_f64()) * step == one;
    let integer = program.steps[program.reading].ty != Type::F32;
    if integer && centre_exact && scale_exact && offset.floor_to_i64() == offset.ceil_to_i64() {
        return Interval::zero();
    }
    // The difference of two floats, the difference from the centre, the centre and the scale: each within
    // an ulp of the largest reading or of v.
    let largest = &(&Interval::from_f64(range.0).magnitude() + &Interval::from_f64(range.1).magnitude())
        + &offset.magnitude();
    let in_v = largest.div(&step.magnitude()).magnitude().mul_pow2(UNIT_ROUNDOFF_LOG2 + 3);
    let slope = exact.derivative().range_around_zero(radius).magnitude();
    (&slope * &in_v).upper()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::paper_coefficients;
    use crate::format::Format;
    use crate::options::{Options, RoutineOptions};
    use crate::output::Output;
    use crate::routine;

    fn routine(format: Format, output: Output) -> Routine {
        let wanted = RoutineOptions { output, ..RoutineOptions::of(format) };
        let options = Options { degree: Some(9), ..Options::default() };
        routine::design(&paper_coefficients(), &options, &wanted).unwrap()
    }

    /// The fast reference's distance from the exact enclosure, in output words, for a reading in its own words.
    fn distance(routine: &Routine, fast_reference: &FastReference, reading: f64) -> f64 {
        let (offset, step) = &routine.plan.reading_word;
        let v = (&Interval::from_f64(reading) - offset).div(step);
        let exact = routine.reference.at(&v).div(&routine.design.unit);
        (&exact - &Interval::from_f64(fast_reference.at(reading))).magnitude().to_f64_up()
    }

    /// A bound of the fast reference that is far below every bound it is used for.
    #[test]
    fn the_fast_reference_is_far_finer_than_the_bounds_it_checks() {
        for (format, output) in
            [(Format::Q31, Output::PowerOfTwo), (Format::Q31, Output::Nano), (Format::F32, Output::F32)]
        {
            let routine = routine(format, output);
            let fast_reference = FastReference::of(&routine);
            let part = fast_reference.error * routine.design.unit.to_f64() / routine.design.bound.total;
            assert!(part < 1e-5, "{format:?}: {part:e} of the bound");
        }
    }

    /// Readings all over the range, scattered by the golden ratio, and its ends.
    #[test]
    fn its_error_holds() {
        for (format, output) in
            [(Format::Q31, Output::PowerOfTwo), (Format::Q31, Output::Nano), (Format::F32, Output::F32)]
        {
            let routine = routine(format, output);
            let fast_reference = FastReference::of(&routine);
            let (lo, hi) = fast_reference.range;
            let scattered = (0..2000).map(|i| (f64::from(i) * 0.618_033_988_749_895).fract());
            for at in scattered.chain([0.0, 1.0]) {
                let reading = lo + (hi - lo) * at;
                let reading = if format.is_fixed() { reading.round() } else { f64::from(reading as f32) };
                let reading = reading.clamp(lo, hi);
                let found = distance(&routine, &fast_reference, reading);
                assert!(
                    found <= fast_reference.error,
                    "{format:?} at {reading}: {found:e} > {:e}",
                    fast_reference.error
                );
            }
        }
    }
}
