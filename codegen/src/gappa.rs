//! The rounding of a routine's operations as a script for Gappa, a prover that shares nothing with
//! [`crate::bound`]: the same claim, proved again by another program.

use minijinja::{Value, context};

use crate::bound;
use crate::program::{Op, Operand, Program, Type};
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
    let variable = &program.steps[program.variable];
    let Some(steps) = steps(program) else { return Ok(None) };
    let fixed = variable.ty != Type::F32;
    let (from, to) = bound::words(program, &routine.plan);
    let ends = if fixed {
        // The integers inside.
        let whole = (from.ceil_to_i64().unwrap_or(i64::MIN), to.floor_to_i64().unwrap_or(i64::MAX));
        (whole.0.to_string(), whole.1.to_string())
    } else {
        (text::double_hex(from.to_f64_down()), text::double_hex(to.to_f64_up()))
    };
    let factor = if fixed { FIXED_SLACK } else { FLOAT_SLACK };
    let slack = format!("claimed here is {factor} times its largest value.");
    let context = context! {
        provenance, name, fixed, slack, steps,
        variable => "x_",
        from => ends.0, to => ends.1,
        last => program.output(),
        bound => text::double_hex((routine.design.bound.rounding * factor).next_up()),
        pieces => PIECES,
    };
    renderer.render("gappa/routine.g", context).map(Some)
}

fn steps(program: &Program) -> Option<Vec<Value>> {
    let steps = program.steps.iter().enumerate().skip(program.variable + 1);
    steps.map(|(i, step)| one(program, i, &step.op)).collect()
}

fn one(program: &Program, i: usize, op: &Op) -> Option<Value> {
    let operand = |o: &Operand| -> Option<Value> {
        Some(match o {
            Operand::Step(s) if *s == program.variable => context! { r => "x_", e => "x_", exact => true },
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
