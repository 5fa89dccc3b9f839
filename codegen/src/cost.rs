//! What a program costs on a core: an estimate of its instructions and its bytes of flash.
//!
//! The estimate is linear: every kind of operation counts so many instructions. The numbers are those of
//! routines that were compiled and counted (`tests/firmware`), and the largest deviation from the counts is
//! part of the model: see [`Core::relative_error`].

use serde::Serialize;

use crate::program::{Op, Operand, Program, Type};

/// A target core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Core {
    /// ARMv6-M: no long multiplication, no floats, no wide constants.
    CortexM0,
    /// ARMv7-M: long multiplication, no floats.
    CortexM3,
    /// ARMv7E-M with single-precision floats.
    CortexM4f,
}

/// The estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// Instructions of the routine's body, without call and return.
    pub instructions: f64,
    /// Bytes of flash: code, constants and table.
    pub flash_bytes: usize,
}

/// Instructions of every kind of operation.
struct Weights {
    constant: f64,
    clamp: f64,
    clamp_f32: f64,
    subtract: f64,
    shift: f64,
    product_high: f64,
    product_split: f64,
    product_short: f64,
    extra_shift: f64,
    entry: f64,
    float_operation: f64,
    float_conversion: f64,
    bytes_per_instruction: f64,
}

impl Core {
    /// All cores.
    pub const ALL: [Core; 3] = [Core::CortexM0, Core::CortexM3, Core::CortexM4f];

    /// The name by which users ask for it.
    pub fn name(self) -> &'static str {
        match self {
            Core::CortexM0 => "cortex-m0",
            Core::CortexM3 => "cortex-m3",
            Core::CortexM4f => "cortex-m4f",
        }
    }

    fn weights(self) -> Weights {
        match self {
            Core::CortexM0 => Weights {
                constant: 1.0,
                clamp: 6.0,
                clamp_f32: 60.0,
                subtract: 1.0,
                shift: 1.0,
                product_high: 42.0,
                product_split: 16.0,
                product_short: 3.0,
                extra_shift: 1.0,
                entry: 2.0,
                float_operation: 75.0,
                float_conversion: 40.0,
                bytes_per_instruction: 2.0,
            },
            Core::CortexM3 | Core::CortexM4f => Weights {
                constant: 1.5,
                clamp: 6.0,
                clamp_f32: if self == Core::CortexM4f { 8.0 } else { 40.0 },
                subtract: 1.0,
                shift: 1.0,
                product_high: if self == Core::CortexM4f { 1.0 } else { 2.0 },
                product_split: 8.0,
                product_short: 2.0,
                extra_shift: 1.0,
                entry: 1.0,
                float_operation: if self == Core::CortexM4f { 1.0 } else { 55.0 },
                float_conversion: if self == Core::CortexM4f { 2.0 } else { 20.0 },
                bytes_per_instruction: 3.4,
            },
        }
    }

    /// The cost of a program on this core.
    pub fn cost(self, program: &Program) -> Cost {
        let w = self.weights();
        let constant = |operand: &Operand| if matches!(operand, Operand::Step(_)) { 0.0 } else { w.constant };
        let mut instructions = 0.0;
        let mut constants = 0;
        for step in &program.steps {
            let operands: &[&Operand] = match &step.op {
                Op::MulAddHigh { a, b, c, .. }
                | Op::MulAddSplit { a, b, c, .. }
                | Op::MulAddShort { a, b, c, .. }
                | Op::MulAddF32 { a, b, c, .. } => &[a, b, c],
                Op::MulF32 { a, b } | Op::Sub { a, b } => &[a, b],
                _ => &[],
            };
            instructions += operands.iter().map(|o| constant(o)).sum::<f64>();
            constants += operands.iter().filter(|o| !matches!(o, Operand::Step(_))).count();
            let extra = |shift: u32| if shift > 0 { w.extra_shift } else { 0.0 };
            instructions += match &step.op {
                Op::Input { .. } => 0.0,
                Op::Clamp { .. } => w.clamp,
                Op::ClampF32 { .. } => w.clamp_f32,
                Op::Sub { .. } if step.ty == Type::F32 => w.float_operation,
                Op::Sub { .. } if step.ty == Type::I64 => 3.0 * w.subtract,
                Op::Sub { .. } => w.subtract,
                Op::ShiftLeft { .. } => w.shift,
                Op::ShiftRight { add, .. } => {
                    if *add == 0 {
                        w.shift
                    } else {
                        w.shift + w.constant + w.subtract
                    }
                }
                Op::Index { .. } => w.shift + w.subtract + w.constant,
                Op::Wrap { add, .. } => {
                    if *add == 0 {
                        w.shift
                    } else {
                        w.shift + w.subtract + w.constant
                    }
                }
                Op::Entry { .. } => w.entry,
                Op::Truncate { .. } | Op::ToF32 { .. } => w.float_conversion,
                Op::MulF32 { .. } => w.float_operation,
                Op::MulAddHigh { shift, .. } => w.product_high + extra(*shift),
                Op::MulAddSplit { shift, .. } => w.product_split + extra(*shift),
                Op::MulAddShort { .. } => w.product_short,
                Op::MulAddF32 { fused, .. } => {
                    if *fused {
                        w.float_operation
                    } else {
                        2.0 * w.float_operation
                    }
                }
            };
        }
        let code = (instructions * w.bytes_per_instruction).ceil() as usize;
        Cost { instructions, flash_bytes: code + 4 * constants + program.table_bytes() }
    }
}
