//! A program's steps as data for the templates, and the helper functions that they call.

use minijinja::{Value, context};

use super::c_type;
use crate::certificate::rust_type;
use crate::options::CShift;
use crate::program::{Op, Operand, Program, Step, Type};
use crate::text;

pub(super) fn operand(program: &Program, operand: &Operand) -> Value {
    match operand {
        Operand::Step(i) => context! { kind => "step", name => &*program.steps[*i].name },
        Operand::Int(value) => context! { kind => "int", value },
        Operand::Float(value) => context! {
            kind => "float",
            decimal => text::float_decimal(*value),
            magnitude_decimal => text::float_decimal(value.abs()),
            hex => text::float_hex(*value),
            negative => value.is_sign_negative(),
            magnitude_hex => text::float_hex(value.abs()),
        },
    }
}

fn type_of(program: &Program, operand: &Operand) -> Type {
    match operand {
        Operand::Step(i) => program.steps[*i].ty,
        Operand::Int(_) => Type::I32,
        Operand::Float(_) => Type::F32,
    }
}

pub(crate) fn steps(program: &Program, which: &[usize]) -> Vec<Value> {
    let assigned = |name: &str, before: usize| {
        which.iter().filter(|&&i| i < before && program.steps[i].name == name).count()
    };
    // Rust has one function that limits, unless there are several types to limit.
    let written = helpers(program, &program.written_steps(), CShift::Strict);
    let several = written.iter().filter(|helper| helper.starts_with("limit_")).count() > 1;
    let limit = |helper: &'static str| if several { helper } else { "limit" };
    let laid_out = which.iter().map(|&index| {
        let step = &program.steps[index];
        let operand = |o: &Operand| operand(program, o);
        let op = match &step.op {
            Op::Input { .. } => context! { kind => "input" },
            Op::State { index } => context! { kind => "state", word => &*program.state[*index].name },
            Op::Word { index } => context! { kind => "word", index },
            Op::Add { a, b } => context! { kind => "add", a => operand(a), b => operand(b) },
            Op::MulAddWide { a, b, c } => {
                context! { kind => "mul_add_wide", a => operand(a), b => operand(b), c => operand(c) }
            }
            Op::High { a, by } => context! { kind => "high", a => operand(a), by },
            Op::Phase { a, factor, by } => context! { kind => "phase", a => operand(a), factor, by },
            Op::Sub { a, b } => context! {
                kind => "sub", a => operand(a), b => operand(b), cast => type_of(program, a) != step.ty,
            },
            Op::Clamp { a, lo, hi } => {
                let from = type_of(program, a);
                let wide = if matches!(from, Type::I32 | Type::U16) { "i32" } else { "i64" };
                let limit = limit(if wide == "i32" { "limit_i32" } else { "limit_i64" });
                context! { kind => "clamp", a => operand(a), lo, hi, wide, cast => from != Type::I32, limit }
            }
            Op::ClampF32 { a, lo, hi } => context! {
                kind => "clamp_f32", a => operand(a), limit => limit("limit_f32"),
                lo => text::float_decimal(*lo), hi => text::float_decimal(*hi),
                lo_hex => text::float_hex(*lo), hi_hex => text::float_hex(*hi),
            },
            Op::ShiftLeft { a, by } => {
                context! { kind => "shift_left", a => operand(a), by, factor => 1u64 << by }
            }
            Op::ShiftRight { a, add, by } => context! {
                kind => "shift_right", a => operand(a), add, by,
                },
            Op::Index { a, add, by } => {
                context! { kind => "index", a => operand(a), add => *add as u32, by, first => add >> by }
            }
            // Modulo 2³² it is one whether the sum or the product by 2^by comes first.
            Op::Wrap { a, add, by } => {
                let add = (*add as u32) << by;
                context! { kind => "wrap", a => operand(a), add, signed => add as i32, by }
            }
            Op::Bits { a, from, bits } => {
                let mask = ((1u64 << bits) - 1) as u32;
                context! { kind => "bits", a => operand(a), from, bits, mask }
            }
            Op::Shifted { a, by, b, add } => {
                context! { kind => "shifted", a => operand(a), by, b => operand(b), add => *add as u32 }
            }
            Op::Around { a, turn } => context! { kind => "around", a => operand(a), turn },
            Op::Entry { index: row, column } => {
                let first = !program.steps[..index].iter().any(|s| matches!(s.op, Op::Entry { .. }));
                context! { kind => "entry", index => operand(row), column, first }
            }
            Op::Truncate { a } => context! { kind => "truncate", a => operand(a) },
            Op::ToF32 { a } => context! { kind => "to_f32", a => operand(a) },
            Op::MulF32 { a, b } => context! { kind => "mul_f32", a => operand(a), b => operand(b) },
            Op::MulAddShort { a, b, by, c } => context! {
                kind => "mul_add_short", a => operand(a), b => operand(b), by, c => operand(c),
            },
            Op::MulAddHigh { a, b, shift, c } | Op::MulAddSplit { a, b, shift, c } => context! {
                kind => "mul_add", helper => product_helper(&step.op), a => operand(a), b => operand(b), shift,
                factor => 1u64 << shift, c => operand(c),
            },
            Op::MulAddF32 { a, b, c, fused } => context! {
                kind => "mul_add_f32", a => operand(a), b => operand(b), c => operand(c), fused,
            },
        };
        context! {
            name => &*step.name,
            type => rust_type(step.ty),
            c_type => c_type(step.ty),
            note => &*step.note,
            reassigned => assigned(&step.name, index) > 0,
            last => index == program.output(),
            constant => assigned(&step.name, program.steps.len()) == 1,
            op,
        }
    });
    laid_out.collect()
}

/// The helper functions that some steps call, in the order in which they are defined.
pub(crate) fn helpers(program: &Program, which: &[usize], shift: CShift) -> Vec<&'static str> {
    let mut helpers = Vec::new();
    let steps = || which.iter().map(|i| &program.steps[*i]);
    if steps().any(|s| s.ty == Type::F32) {
        helpers.push("float_guard");
    }
    for step in steps() {
        let helper = match &step.op {
            // Of counts, in place.
            Op::Clamp { .. } if step.ty == Type::U32 => continue,
            Op::Clamp { a, .. } if matches!(type_of(program, a), Type::I32 | Type::U16) => "limit_i32",
            Op::Clamp { .. } => "limit_i64",
            Op::ClampF32 { .. } => "limit_f32",
            Op::Around { .. } => "around",
            Op::MulAddHigh { .. } => "mul_high",
            Op::MulAddSplit { .. } => "mul_split",
            Op::MulAddShort { .. } => "mul_short",
            Op::High { .. } => "high_word",
            Op::Wrap { .. } => "to_signed",
            Op::Phase { .. } => {
                // It rests on the other, which comes first.
                if !helpers.contains(&"to_signed") {
                    helpers.push("to_signed");
                }
                "phase_of"
            }
            _ => continue,
        };
        if !helpers.contains(&helper) {
            helpers.push(helper);
        }
    }
    let shifts =
        |op: &Op| matches!(op, Op::MulAddSplit { .. } | Op::MulAddShort { .. } | Op::ShiftRight { .. });
    // Of a table of two segments the sign says which it is.
    let signed_index = |s: &Step| matches!(s.op, Op::Index { by, .. } if by < 31) && s.ty == Type::I32;
    if shift == CShift::Strict && steps().any(|s| shifts(&s.op) || signed_index(s)) {
        helpers.insert(0, "shift_right");
    }
    helpers
}

/// The function that takes the high part of a product.
fn product_helper(op: &Op) -> &'static str {
    match op {
        Op::MulAddSplit { .. } => "mul_split",
        _ => "mul_high",
    }
}
