//! The rounding of a routine's operations as a script for Gappa, a prover that shares nothing with
//! `bound`: the same claim, proved again by another program.
//!
//! In fixed point an operation's rounding does not depend on the coefficients, only on the place in the segment.
//! So for a table one goal covers all segments: the coefficients are any integers of their columns' ranges.
//!
//! Where terms of further physics are subtracted, the same goal covers the combination: every product of
//! polynomials, every sum. What is proved of a word in another way enters as a given: that a limited word and a word
//! of the state (and an exponential by more than two squarings, which Gappa does not follow) lie in their ranges and are
//! no further from exact than the bound has it, and how far an
//! approximated function or a rounded coefficient is off ([`ErrorAccount`](crate::physics::ErrorAccount)).

mod steps;

use minijinja::{Value, context};

use crate::bound;
use crate::exact::Interval;
use crate::program::{Op, Program, Step, Type};
use crate::render::{RenderError, Renderer};
use crate::routine::Routine;
use crate::text;

/// Fixed point: both follow the same recurrence; Gappa rounds its numbers to 60 bits.
const FIXED_SLACK: f64 = 1.000_001;
/// Products from halves are off by 3/2 and up to 1/2 more, which grows with the first factor: Gappa has that over all pieces
/// or rows at once.
const SPLIT_SLACK: f64 = 1.34;
/// Floats: Gappa encloses the partial sums more coarsely than the certificate does, so that a sum near a power
/// of two may count with twice the ulp.
const FLOAT_SLACK: f64 = 1.02;
/// Pieces into which Gappa is told to cut the range of a float.
const PIECES: u32 = 64;

/// The script for `routine`; `None` where an operation has no counterpart in it.
///
/// # Errors
/// [`RenderError`] of the template.
pub fn script(
    renderer: &Renderer,
    routine: &Routine,
    name: &str,
    provenance: &str,
) -> Result<Option<String>, RenderError> {
    let program = &routine.design.program;
    let fixed = program.steps[program.variable].ty != Type::F32;
    let words = bound::words(program, &routine.plan);
    // Whether the function of the reading is a table, and not only one of a term.
    let account = routine.design.account.as_ref();
    let of_term = |i: &usize| account.is_some_and(|account| account.steps.contains_key(i));
    let own =
        |of: &dyn Fn(&Op) -> bool| (0..program.steps.len()).any(|i| !of_term(&i) && of(&program.steps[i].op));
    let table = own(&|op| matches!(op, Op::Index { .. }));
    let mut variables = Vec::new();
    let place = own(&|op| matches!(op, Op::Wrap { .. }));
    if !table || !place || routine.design.account.is_some() {
        let (from, to) = &words;
        let ends = if fixed {
            // The integers inside.
            let whole = (from.ceil_to_i64().unwrap_or(i64::MIN), to.floor_to_i64().unwrap_or(i64::MAX));
            (whole.0.to_string(), whole.1.to_string())
        } else {
            (text::float_hex(from.to_f64_down()), text::float_hex(to.to_f64_up()))
        };
        variables.push(context! { name => "x_", from => ends.0, to => ends.1, integer => true });
    }
    if table {
        variables.extend(of_table(program, words, &of_term));
    }
    let Some(steps) = steps::of(program, routine.design.account.as_ref()) else { return Ok(None) };
    variables.extend(steps.variables);
    let split = program.steps.iter().any(|s| matches!(s.op, Op::MulAddSplit { .. }));
    let factor = match (fixed, split) {
        (true, true) => SPLIT_SLACK,
        (true, false) => FIXED_SLACK,
        (false, _) => FLOAT_SLACK,
    };
    let slack = format!("claimed here is {factor} times its largest value.");
    let context = context! {
        provenance, name, fixed, slack, variables,
        steps => steps.computed,
        bridges => steps.bridges,
        narrower => steps.narrower,
        result => steps.result,
        terms => routine.design.account.is_some(),
        table => if table { program.table.len() } else { 0 },
        place,
        split,
        bound => text::float_hex((routine.design.bound.rounding * factor).next_up()),
        pieces => PIECES,
    };
    renderer.render("gappa/routine.g", context).map(Some)
}

/// The place in a segment, and a coefficient of each column: the hull of what any segment that words between
/// two ends reach has.
fn of_table(program: &Program, words: (Interval, Interval), of_term: &dyn Fn(&usize) -> bool) -> Vec<Value> {
    let segments = bound::segments(program, words);
    let hull = |values: &mut dyn Iterator<Item = i64>| {
        let first = values.next().unwrap_or(0);
        values.fold((first, first), |(lo, hi), v| (lo.min(v), hi.max(v)))
    };
    let range = |step: &Step| match step.op {
        Op::Wrap { add, by, .. } => Some(hull(&mut segments.iter().flat_map(|(_, from, to)| {
            [from, to].map(|word| {
                let word = i128::from(word.round_to_i64().unwrap_or(0));
                i64::from(((word + i128::from(add)) << by) as i32)
            })
        }))),
        Op::Entry { column, .. } => Some(hull(
            &mut segments.iter().filter_map(|(row, ..)| program.table.get(*row)?.get(column).copied()),
        )),
        _ => None,
    };
    let named = (program.variable + 1..program.steps.len()).filter(|i| !of_term(i));
    let of = |i: usize| {
        range(&program.steps[i]).map(|(from, to)| {
            let name = steps::of_segment(program, i);
            context! { name, from => from.to_string(), to => to.to_string(), integer => true }
        })
    };
    named.filter_map(of).collect()
}
