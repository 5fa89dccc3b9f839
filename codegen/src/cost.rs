//! What a program costs on a core: an estimate of its instructions and its bytes of flash.
//!
//! The estimate is linear: every kind of operation counts so many instructions. The numbers are those of
//! routines that were compiled and counted (`tests/firmware`), and the largest deviation from the counts is
//! part of the model: see [`Core::RELATIVE_ERROR`].

use serde::Serialize;

use crate::program::{Op, Operand, Program, Type};

/// A target core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Core {
    /// ARMv6-M: no long multiplication, no floats, no wide constants.
    CortexM0,
    /// ARMv7-M: long multiplication, no floats.
    CortexM3,
    /// ARMv7E-M with single-precision floats, and a high product with its sum as one instruction.
    CortexM4f,
    /// The same instructions, with floats of either precision.
    CortexM7,
    /// ARMv8-M with the DSP extension and single-precision floats.
    CortexM33,
}

/// The estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// Instructions of the routine's body, without call and return.
    pub instructions: f64,
    /// Bytes of flash: code, constants and table.
    pub flash_bytes: usize,
}

/// Eleven times the flash is accepted for half of the instructions, by judgement: a table of hundreds of rows has to save
/// much, a short one little.
const FLASH_EXPONENT: f64 = 0.29;

impl Cost {
    /// What is to be small: instructions where the flash that there is is known, otherwise instructions times a power of the
    /// bytes of flash.
    pub fn worth(self, flash_is_given: bool) -> f64 {
        let flash = if flash_is_given { 1.0 } else { (self.flash_bytes as f64).powf(FLASH_EXPONENT) };
        self.instructions * flash
    }

    /// With what is added.
    #[must_use]
    pub fn plus(self, added: Cost) -> Cost {
        let flash_bytes = self.flash_bytes + added.flash_bytes;
        Cost { instructions: self.instructions + added.instructions, flash_bytes }
    }

    /// What it is more than another.
    #[must_use]
    pub fn less(self, other: Cost) -> Cost {
        let flash_bytes = self.flash_bytes.saturating_sub(other.flash_bytes);
        Cost { instructions: (self.instructions - other.instructions).max(0.0), flash_bytes }
    }
}

/// Instructions of every kind of operation.
#[derive(Clone, Copy)]
struct Weights {
    constant: f64,
    clamp: f64,
    /// To −2ⁿ…2ⁿ−1.
    saturate: f64,
    clamp_f32: f64,
    subtract: f64,
    shift: f64,
    product_high: f64,
    /// Its shift to the left before the sum.
    product_shift: f64,
    product_split: f64,
    product_short: f64,
    /// Of a row of the table.
    address: f64,
    /// Of a row of three words, more, where the argument is limited: a register beside it for the table's address.
    packed: f64,
    entry: f64,
    /// Of the registers that a row of four words takes.
    spill: f64,
    /// A field of bits.
    bits: f64,
    float_operation: f64,
    float_conversion: f64,
    bytes_per_instruction: f64,
    /// The return, and the address of a table.
    bytes_of_ends: usize,
    /// What a routine of the compiler's library takes, once, where an operation is a call.
    library_bytes: usize,
}

/// An operation of more instructions is a call of so many.
const CALL: f64 = 6.0;

impl Core {
    /// All cores.
    pub const ALL: [Core; 5] =
        [Core::CortexM0, Core::CortexM3, Core::CortexM4f, Core::CortexM7, Core::CortexM33];

    /// Those that a routine costs something else on: M7 and M33 have the instructions of M4F that routines are made of, and
    /// take as many of them but for two or three.
    pub const APART: [Core; 3] = [Core::CortexM0, Core::CortexM3, Core::CortexM4f];

    /// The name by which users ask for it.
    pub fn name(self) -> &'static str {
        match self {
            Core::CortexM0 => "cortex-m0",
            Core::CortexM3 => "cortex-m3",
            Core::CortexM4f => "cortex-m4f",
            Core::CortexM7 => "cortex-m7",
            Core::CortexM33 => "cortex-m33",
        }
    }

    /// Whether it multiplies and adds single-precision floats in one instruction, rounded once (FPv4-SP, FPv5).
    pub fn fuses(self) -> bool {
        matches!(self, Core::CortexM4f | Core::CortexM7 | Core::CortexM33)
    }

    /// Instructions of fully defined C as gcc translates it at -O2, fitted by hand to the counted table.
    fn weights(self) -> Weights {
        let common = Weights {
            constant: 1.0,
            clamp: 8.0,
            saturate: 1.0,
            clamp_f32: 8.0,
            subtract: 1.0,
            shift: 1.0,
            product_high: 2.0,
            product_shift: 0.0,
            product_split: 7.2,
            product_short: 1.7,
            address: 2.0,
            packed: 0.0,
            entry: 1.0,
            spill: 1.0,
            bits: 1.0,
            float_operation: 1.0,
            float_conversion: 2.0,
            bytes_per_instruction: 2.8,
            bytes_of_ends: 6,
            library_bytes: 0,
        };
        let dsp = Weights {
            constant: 0.95,
            address: 2.05,
            product_high: 1.0,
            product_shift: 1.0,
            product_split: 7.4,
            spill: 2.0,
            bytes_per_instruction: 3.4,
            ..common
        };
        match self {
            Core::CortexM4f => dsp,
            Core::CortexM7 => Weights { packed: 1.9, product_split: 7.0, ..dsp },
            Core::CortexM33 => Weights { constant: 1.2, packed: 1.9, product_split: 7.0, ..dsp },
            Core::CortexM3 => Weights {
                packed: 0.5,
                entry: 1.1,
                clamp_f32: 45.0,
                float_operation: 47.0,
                float_conversion: 20.0,
                library_bytes: 900,
                ..common
            },
            Core::CortexM0 => Weights {
                clamp_f32: 100.0,
                product_high: 49.0,
                product_split: 9.9,
                product_short: 3.5,
                saturate: 8.0,
                address: 3.0,
                packed: 2.0,
                entry: 1.7,
                bits: 2.0,
                float_operation: 100.0,
                float_conversion: 40.0,
                bytes_per_instruction: 2.0,
                library_bytes: 100,
                ..common
            },
        }
    }

    /// The largest relative deviation of the estimated instructions from the counted ones, over the routines
    /// that are counted (held by a test).
    pub const RELATIVE_ERROR: f64 = 0.10;

    /// The cost of a program on this core.
    pub fn cost(self, program: &Program) -> Cost {
        let w = self.weights();
        let constant = |operand: &Operand| if matches!(operand, Operand::Step(_)) { 0.0 } else { w.constant };
        let (mut instructions, mut inline) = (0.0, 0.0);
        let mut constants = 0;
        let mut library = 0;
        for step in &program.steps {
            let operands: &[&Operand] = match &step.op {
                Op::MulAddHigh { a, b, c, .. }
                | Op::MulAddSplit { a, b, c, .. }
                | Op::MulAddShort { a, b, c, .. }
                | Op::MulAddF32 { a, b, c, .. } => &[a, b, c],
                Op::MulF32 { a, b } | Op::Sub { a, b } | Op::Add { a, b } => &[a, b],
                _ => &[],
            };
            let loads = operands.iter().map(|o| constant(o)).sum::<f64>();
            constants += operands.iter().filter(|o| !matches!(o, Operand::Step(_))).count();
            let if_any = |added: i64, cost: f64| if added == 0 { 0.0 } else { cost };
            let operation = match &step.op {
                Op::Input { .. } => 0.0,
                // Loaded, and stored in the end.
                Op::State { .. } => 2.0,
                Op::Add { .. } => w.subtract,
                Op::MulAddWide { .. } => w.constant + w.product_high + w.subtract,
                Op::High { .. } => 2.0 * w.shift,
                // The low word is wanted as well.
                Op::Phase { .. } => w.constant + w.product_high + w.shift,
                Op::Clamp { lo, hi, .. } if *lo == -hi - 1 && (hi + 1).count_ones() == 1 => w.saturate,
                Op::Clamp { .. } => w.clamp,
                Op::ClampF32 { .. } => w.clamp_f32,
                Op::Sub { .. } if step.ty == Type::F32 => w.float_operation,
                Op::Sub { .. } if step.ty == Type::I64 => 3.0 * w.subtract,
                Op::Sub { .. } => w.subtract,
                Op::ShiftLeft { .. } => w.shift,
                Op::ShiftRight { add, .. } => w.shift + if_any(*add, w.constant + w.subtract),
                // The constant is one that an instruction holds, or part of the table's address.
                Op::Index { .. } => {
                    let width = program.table.first().map_or(0, Vec::len);
                    let sum = if step.ty == Type::U32 { w.subtract } else { 0.0 };
                    let limited = program.clamped != program.reading;
                    let packed = if limited && !width.is_power_of_two() { w.packed } else { 0.0 };
                    w.shift + sum + w.address + packed + if width > 3 { w.spill } else { 0.0 }
                }
                Op::Wrap { add, .. } => w.shift + if_any(*add, w.constant + w.subtract),
                Op::Bits { .. } => w.bits,
                // A constant, and twice a comparison and a conditional sum.
                Op::Around { .. } => w.constant + w.clamp,
                Op::Shifted { add, .. } => w.shift + w.subtract + if_any(*add, w.constant + w.subtract),
                Op::Entry { .. } | Op::Word { .. } => w.entry,
                Op::Truncate { .. } | Op::ToF32 { .. } => w.float_conversion,
                Op::MulF32 { .. } => w.float_operation,
                Op::MulAddHigh { shift, .. } => {
                    w.product_high + if *shift > 0 { w.product_shift } else { 0.0 }
                }
                Op::MulAddSplit { .. } => w.product_split,
                Op::MulAddShort { .. } => w.product_short,
                Op::MulAddF32 { fused: true, .. } => w.float_operation,
                Op::MulAddF32 { .. } => 2.0 * w.float_operation,
            };
            instructions += loads + operation;
            inline += loads + if operation > 2.0 * CALL { CALL } else { operation };
            if operation > 2.0 * CALL {
                library = w.library_bytes;
            }
        }
        let code = (inline * w.bytes_per_instruction).ceil() as usize;
        let flash_bytes = code + w.bytes_of_ends + library + 4 * constants + program.table_bytes();
        Cost { instructions, flash_bytes }
    }
}
