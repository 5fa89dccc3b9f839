//! The rounding of a routine's operations as a script for Gappa, a prover that shares nothing with
//! [`crate::bound`]: the same claim, proved again by another program.
//!
//! In fixed point an operation's rounding does not depend on the coefficients, only on the place in the segment.
//! So for a table one goal covers all segments: the coefficients are any integers of their columns' ranges.

use minijinja::{Value, context};

use crate::bound;
use crate::exact::Interval;
use crate::program::{Op, Operand, Program, Step, Type};
use crate::render::{RenderError, Renderer};
use crate::routine::Routine;
use crate::text;

/// Fixed point: both follow the same recurrence; Gappa rounds its numbers to 60 bits.
const FIXED_SLACK: f64 = 1.000_001;
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
    let Some(steps) = steps(program) else { return Ok(None) };
    let words = bound::words(program, &routine.plan);
    let variables = if program.index().is_some() {
        of_table(program, words)
    } else {
        let (from, to) = words;
        let ends = if fixed {
            // The integers inside.
            let whole = (from.ceil_to_i64().unwrap_or(i64::MIN), to.floor_to_i64().unwrap_or(i64::MAX));
            (whole.0.to_string(), whole.1.to_string())
        } else {
            (text::double_hex(from.to_f64_down()), text::double_hex(to.to_f64_up()))
        };
        vec![context! { name => "x_", from => ends.0, to => ends.1 }]
    };
    let factor = if fixed { FIXED_SLACK } else { FLOAT_SLACK };
    let slack = format!("claimed here is {factor} times its largest value.");
    let context = context! {
        provenance, name, fixed, slack, steps, variables,
        table => program.table.len(),
        split => program.steps.iter().any(|s| matches!(s.op, Op::MulAddSplit { .. })),
        last => program.output(),
        bound => text::double_hex((routine.design.bound.rounding * factor).next_up()),
        pieces => PIECES,
    };
    renderer.render("gappa/routine.g", context).map(Some)
}

/// The place in a segment, and a coefficient of each column: the hull of what any segment that words between
/// two ends reach has.
fn of_table(program: &Program, words: (Interval, Interval)) -> Vec<Value> {
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
    let named = program.steps.iter().enumerate().skip(program.variable + 1);
    let of = |(i, step): (usize, &Step)| {
        range(step).map(|(from, to)| {
            context! { name => free(program, i), from => from.to_string(), to => to.to_string() }
        })
    };
    named.filter_map(of).collect()
}

/// Name of a step whose result is any number of a range: the variable, the place in a segment, a coefficient.
fn free(program: &Program, i: usize) -> String {
    if i == program.variable { "x_".into() } else { format!("{}_", program.steps[i].name) }
}

fn is_free(program: &Program, i: usize) -> bool {
    i == program.variable || matches!(program.steps[i].op, Op::Wrap { .. } | Op::Entry { .. })
}

fn steps(program: &Program) -> Option<Vec<Value>> {
    let steps = program.steps.iter().enumerate().skip(program.variable + 1);
    let computed = steps.filter(|(i, step)| !is_free(program, *i) && !matches!(step.op, Op::Index { .. }));
    computed.map(|(i, step)| one(program, i, &step.op)).collect()
}

fn one(program: &Program, i: usize, op: &Op) -> Option<Value> {
    let operand = |o: &Operand| -> Option<Value> {
        Some(match o {
            Operand::Step(s) if is_free(program, *s) => {
                let name = free(program, *s);
                context! { r => &*name, e => &*name, exact => true }
            }
            Operand::Step(s) if *s > program.variable => {
                context! { r => format!("r_{s}"), e => format!("e_{s}"), exact => false }
            }
            Operand::Step(_) => return None,
            Operand::Int(v) => context! { r => v, e => v, exact => true },
            Operand::Float(v) => {
                let hex = text::float_hex(*v);
                context! { r => &*hex, e => &*hex, exact => true }
            }
        })
    };
    Some(match op {
        Op::MulAddHigh { a, b, shift, c } => context! {
            i, kind => "mul_add_high", a => operand(a)?, b => operand(b)?, c => operand(c)?,
            factor => 1u64 << shift, by => 32,
            scale => format!(" * 1b-{}", 32 - shift),
        },
        Op::MulAddSplit { a, b, shift, c } => context! {
            i, kind => "mul_add_split", a => operand(a)?, b => operand(b)?, c => operand(c)?,
            factor => 1u64 << shift,
            scale => format!(" * 1b-{}", 32 - shift),
        },
        Op::MulAddShort { a, b, by, c } => context! {
            i, kind => "mul_add_high", a => operand(a)?, b => operand(b)?, c => operand(c)?,
            factor => 1, by,
            scale => format!(" * 1b-{by}"),
        },
        Op::MulAddF32 { a, b, c, fused } => context! {
            i, kind => "mul_add_f32", fused, a => operand(a)?, b => operand(b)?, c => operand(c)?, scale => "",
        },
        Op::MulF32 { a, b } => context! {
            i, kind => "mul_f32", a => operand(a)?, b => operand(b)?, c => Value::from(()), scale => "",
        },
        Op::ToF32 { a } => context! {
            i, kind => "to_f32", a => operand(a)?, b => Value::from(()), c => Value::from(()), scale => "",
        },
        _ => return None,
    })
}
