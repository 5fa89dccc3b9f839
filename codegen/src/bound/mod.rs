//! The proof: an upper bound of |generated − reference| over every valid input, in exact arithmetic.
//!
//! The range of the normalised variable is cut into pieces. On each piece every step's result is written as
//! an exactly known polynomial plus an error no larger than a radius, the radius being the sum of what
//! every rounding so far can have contributed; the distance of the last polynomial from the reference is then
//! certified by branch and bound. A truncation's mean of −½ is part of the polynomial, so only ±½ is left as
//! error. The variable's own rounding (from the argument to v) enters through the slope of the reference.
//!
//! At the same time each integer step is shown to fit its type for *every* argument, valid or not: before the
//! range is clamped by the limits of the types, afterwards by the ranges on the pieces, which cover it.

mod input;
mod piece;
mod steps;
mod value;

use crate::exact::{Interval, Polynomial};
use crate::input::InputPlan;
use crate::program::{Program, Stage, Type};
use crate::quantize::Rounding;
use crate::reference::Reference;

use piece::{Piece, pieces};
pub use piece::{reach, segments, variable_error, words};
use steps::run;
pub(crate) use value::of_type;

/// The certified supremum may exceed the true one by this part of itself, 2⁻¹⁸, 4 parts in a million.
const SUPREMUM_SLACK_LOG2: i64 = -18;

/// A routine's bound and what it is made of, on the piece where it is largest; in the output's unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bound {
    /// The bound: the sum of the parts.
    pub total: f64,
    /// Supremum of the distance between the polynomial with its rounded coefficients and the reference.
    pub approximation: f64,
    /// What the rounding of the argument to the variable can shift the result.
    pub input: f64,
    /// Rounding of the operations that evaluate the polynomial.
    pub evaluation: f64,
    /// Rounding to the output's format.
    pub output: f64,
    /// Whatever the terms of further physics add ([`crate::physics`]).
    pub terms: f64,
    /// The largest `evaluation` + `output` on any piece, and what the words of the terms are off, in output words.
    pub rounding: f64,
    /// Smallest and largest output word (float: value), over every argument, valid or not.
    pub output_range: (f64, f64),
}

/// A program that cannot be used: some step may leave its type.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step} ({name}) reaches {from}…{to}, beyond its type {ty:?}")]
pub struct Overflows {
    /// Index of the step.
    pub step: usize,
    /// Name of its variable.
    pub name: String,
    /// Which part of the routine it belongs to.
    pub stage: Stage,
    /// What it can reach.
    pub from: f64,
    /// See `from`.
    pub to: f64,
    /// The type.
    pub ty: Type,
}

fitter::errors!(plain Overflows);

impl Overflows {
    /// Whether a range lies within the integers of a type; otherwise what is wrong with the step of this number, name and
    /// stage.
    pub(crate) fn unless_inside(
        range: &Interval,
        ty: Type,
        (step, name, stage): (usize, &str, Stage),
    ) -> Result<(), Overflows> {
        if ty.range().is_none() || range.inside(&of_type(ty)) {
            return Ok(());
        }
        let (from, to) = (range.to_f64_down(), range.to_f64_up());
        Err(Overflows { step, name: name.into(), stage, from, to, ty })
    }
}

/// The output as a polynomial of v, with every bias, where the variable's word lies in `from`…`to`: what the
/// coefficient search starts from.
///
/// # Errors
/// [`Overflows`] as for [`bound`].
pub fn output_polynomial(
    program: &Program,
    plan: &InputPlan,
    from: &Interval,
    to: &Interval,
) -> Result<Polynomial, Overflows> {
    let piece = Piece::new(program, plan, from, to);
    Ok(piece.in_v(&run(program, &piece)?.sum.polynomial))
}

/// The largest rounding of evaluation and output on any piece, in output words, whatever coefficients in their
/// ranges a page holds: how far the result is from the polynomial that the page stands for.
///
/// # Errors
/// [`Overflows`] where some argument, valid or not, with some coefficients in their ranges, could overflow a step.
pub fn rounding(program: &Program, plan: &InputPlan) -> Result<f64, Overflows> {
    let mut largest = 0.0f64;
    for (a, b) in pieces(program, words(program, plan)) {
        let out = run(program, &Piece::new(program, plan, &a, &b))?;
        largest = largest.max((&out.sum.evaluation + &out.sum.output).to_f64_up());
    }
    Ok(largest)
}

/// What the operations round on each piece, in the reference's unit: what the search of coefficients has to add to the
/// distance of the polynomial.
///
/// # Errors
/// [`Overflows`] as for [`bound`].
pub fn roundings(program: &Program, plan: &InputPlan, unit: &Interval) -> Result<Vec<Rounding>, Overflows> {
    let in_v = |w: &Interval| w.mul_pow2(-program.variable_exponent).to_f64();
    let of = |(a, b): (Interval, Interval)| {
        let out = run(program, &Piece::new(program, plan, &a, &b))?;
        let most = (&(&out.sum.evaluation + &out.sum.output) * unit).to_f64_up();
        Ok(Rounding { from: in_v(&a), to: in_v(&b), most })
    };
    pieces(program, words(program, plan)).into_iter().map(of).collect()
}

/// What is known of a piece before the distance of the polynomial from the reference is.
struct Followed {
    from: Interval,
    to: Interval,
    difference: Polynomial,
    remainder: Interval,
    input: Interval,
    evaluation: Interval,
    output: Interval,
    /// Their sum: all but the distance.
    beside: Interval,
}

impl Followed {
    fn bound(&self, total: &Interval, supremum: &Interval) -> Bound {
        let approximation = (supremum + &self.remainder).upper();
        let [total, approximation, input, evaluation, output] =
            [total, &approximation, &self.input, &self.evaluation, &self.output].map(Interval::to_f64_up);
        Bound { total, approximation, input, evaluation, output, ..Bound::default() }
    }
}

/// Bounds `program` against `reference`; one output word (float: 1) stands for `unit` of the reference's unit.
///
/// # Errors
/// [`Overflows`] where some argument, valid or not, could overflow a step.
pub fn bound(
    program: &Program,
    plan: &InputPlan,
    reference: &Reference,
    unit: &Interval,
) -> Result<Bound, Overflows> {
    let slope = reference.polynomial.derivative();
    let mut followed = Vec::new();
    let mut output_range: Option<Interval> = None;
    let mut rounding = 0.0f64;
    // What the distance and the bound come to somewhere.
    let (mut largest, mut reached) = (Interval::zero(), Interval::zero());
    for (a, b) in pieces(program, words(program, plan)) {
        let piece = Piece::new(program, plan, &a, &b);
        let out = run(program, &piece)?;
        output_range = Some(output_range.map_or(out.range.clone(), |r| r.hull(&out.range)));
        rounding = rounding.max((&out.sum.evaluation + &out.sum.output).to_f64_up());
        let difference = piece.in_v(&out.sum.polynomial).scale(unit).sub(&reference.polynomial);
        let input = (&slope.range(&piece.wide_from, &piece.wide_to).magnitude() * &piece.input_error).upper();
        let remainder = &reference.remainder + &reference.remainder;
        let evaluation = (&out.sum.evaluation * unit).upper();
        let output = (&out.sum.output * unit).upper();
        let beside = (&(&remainder + &input) + &(&evaluation + &output)).upper();
        let middle = difference.at(&piece.centre).magnitude_lower();
        largest = largest.magnitude_max(&middle);
        let sum = &middle + &beside;
        reached = reached.magnitude_max(&sum);
        followed.push((
            sum,
            Followed { from: a, to: b, difference, remainder, input, evaluation, output, beside },
        ));
    }
    // The largest first: then most others are seen to be smaller at once.
    followed.sort_by(|(a, _), (b, _)| b.to_f64().total_cmp(&a.to_f64()));
    let tolerance = largest.hull(&Interval::pow2(-300)).magnitude().mul_pow2(SUPREMUM_SLACK_LOG2);
    let mut worst: Option<(Interval, Bound)> = None;
    for (_, piece) in followed {
        let least = (&reached - &piece.beside).magnitude_max(&Interval::zero());
        let v = |w: &Interval| w.mul_pow2(-program.variable_exponent);
        let supremum =
            piece.difference.supremum_beside(&v(&piece.from), &v(&piece.to), &tolerance, &least).upper();
        let sum = (&supremum + &piece.beside).upper();
        if worst.as_ref().is_none_or(|(w, _)| !sum.certainly_le(w)) {
            reached = reached.magnitude_max(&(&sum - &tolerance));
            worst = Some((sum.clone(), piece.bound(&sum, &supremum)));
        }
    }
    if plan.reach != (plan.word_from.clone(), plan.word_to.clone()) {
        // Nothing is limited: no bound beyond the range, but no overflow either.
        for (a, b) in pieces(program, reach(program, plan)) {
            let out = run(program, &Piece::new(program, plan, &a, &b))?;
            output_range = Some(output_range.map_or(out.range.clone(), |r| r.hull(&out.range)));
        }
    }
    let range = output_range.unwrap_or_else(Interval::zero);
    let (_, bound) = worst.unwrap_or_else(|| unreachable!("there is at least one piece"));
    Ok(Bound { rounding, output_range: (range.to_f64_down(), range.to_f64_up()), ..bound })
}
