//! The pieces into which the range of the variable is cut: on each a routine is one polynomial.

use super::input::input_error;
use crate::exact::{Interval, Polynomial};
use crate::input::InputPlan;
use crate::program::Program;

/// Pieces into which the range is cut.
const PIECES: i64 = 64;

/// A range of the variable's words, and what is known on it before evaluation begins.
pub(super) struct Piece {
    pub(super) words: Interval,
    pub(super) centre: Interval,
    pub(super) radius: Interval,
    pub(super) input_error: Interval,
    /// The piece in v, widened by the input's error.
    pub(super) wide_from: Interval,
    pub(super) wide_to: Interval,
}

impl Piece {
    pub(super) fn new(program: &Program, plan: &InputPlan, from: &Interval, to: &Interval) -> Self {
        let words = from.hull(to);
        let in_v = words.mul_pow2(-program.variable_exponent);
        let centre = in_v.midpoint();
        let radius = (&in_v - &centre).magnitude();
        let input_error = input_error(program, plan, &words);
        let wide_from = (&in_v.lower() - &input_error).lower();
        let wide_to = (&in_v.upper() + &input_error).upper();
        Piece { words, centre, radius, input_error, wide_from, wide_to }
    }

    /// A polynomial of the distance from the centre as one of v.
    pub(super) fn in_v(&self, polynomial: &Polynomial) -> Polynomial {
        polynomial.shift(&-self.centre.clone())
    }
}

/// The words of the variable for readings in the range: the plan's, widened by its rounding.
pub fn words(program: &Program, plan: &InputPlan) -> (Interval, Interval) {
    widened(program, plan, &plan.word_from, &plan.word_to)
}

/// All words that the variable can take, whatever the arguments.
pub fn reach(program: &Program, plan: &InputPlan) -> (Interval, Interval) {
    widened(program, plan, &plan.reach.0, &plan.reach.1)
}

fn widened(program: &Program, plan: &InputPlan, from: &Interval, to: &Interval) -> (Interval, Interval) {
    let error = input_error(program, plan, &from.hull(to)).mul_pow2(program.variable_exponent);
    (from - &error, to + &error)
}

/// The pieces on which a program is followed: its table's segments, or equal parts.
pub(super) fn pieces(program: &Program, (from, to): (Interval, Interval)) -> Vec<(Interval, Interval)> {
    if program.index().is_some() {
        return segments(program, (from, to)).into_iter().map(|(_, a, b)| (a, b)).collect();
    }
    let width = &to - &from;
    let cut = |i: i64| match i {
        0 => from.clone(),
        PIECES => to.clone(),
        _ => (&from + &(&width * &Interval::from_ratio(i, PIECES))).midpoint(),
    };
    (0..PIECES).map(|i| (cut(i), cut(i + 1))).collect()
}

/// The rows of the table that words between two ends reach, with the first and last word that reaches each.
pub fn segments(program: &Program, (from, to): (Interval, Interval)) -> Vec<(usize, Interval, Interval)> {
    let Some((add, by)) = program.index() else { return Vec::new() };
    let (first, last) = (from.floor_to_i64().unwrap_or(i64::MIN), to.ceil_to_i64().unwrap_or(i64::MAX));
    let row = |word: i64| (word + add) >> by;
    (row(first)..=row(last))
        .map(|i| {
            let (a, b) = (((i << by) - add).max(first), (((i + 1) << by) - add - 1).min(last));
            (usize::try_from(i).unwrap_or(usize::MAX), Interval::from_int(a), Interval::from_int(b))
        })
        .collect()
}

/// The largest distance of the variable from the exact reading, in v, for any argument.
pub fn variable_error(program: &Program, plan: &InputPlan) -> Interval {
    let (from, to) = reach(program, plan);
    input_error(program, plan, &from.hull(&to))
}
