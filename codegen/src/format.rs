//! Number formats of the evaluation.

use crate::program::{Op, Operand};

/// The number format of the evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Format {
    /// 32-bit integers, high words of products.
    Q31,
    /// The same from 16-bit halves, for cores without a long multiplication.
    Q31Split,
    /// 16-bit integers, 32-bit products.
    Q15,
    /// IEEE binary32.
    F32,
    /// The same with products and sums rounded once together, by cores that do so in one instruction.
    #[cfg_attr(feature = "program", value(skip))]
    F32Fma,
}

impl Format {
    /// All formats that every core has.
    pub const ALL: [Format; 4] = [Format::Q31, Format::Q31Split, Format::Q15, Format::F32];

    /// The name by which users ask for it.
    pub fn name(self) -> &'static str {
        match self {
            Format::Q31 => "q31",
            Format::Q31Split => "q31-split",
            Format::Q15 => "q15",
            Format::F32 => "f32",
            Format::F32Fma => "f32-fma",
        }
    }

    /// The same with products and sums rounded once together, where that is wanted and the format has it.
    #[must_use]
    pub fn fused(self, wanted: bool) -> Format {
        if wanted && self == Format::F32 { Format::F32Fma } else { self }
    }

    /// Whether it is a fixed-point format.
    pub fn is_fixed(self) -> bool {
        !matches!(self, Format::F32 | Format::F32Fma)
    }

    /// Bits of a word's magnitude; 24 for floats.
    pub fn bits(self) -> i64 {
        match self {
            Format::Q31 | Format::Q31Split => 31,
            Format::Q15 => 15,
            Format::F32 | Format::F32Fma => 24,
        }
    }

    /// How many bits finer the last sum may be than the one before: the product of short words has them.
    pub fn last_gain(self) -> i64 {
        if self == Format::Q15 { 10 } else { 0 }
    }

    /// c + (a·b, scaled so that b is the variable v)·2^shift, with the rounding of this fixed-point format.
    pub fn mul_add(self, a: Operand, b: Operand, shift: u32, c: Operand) -> Op {
        match self {
            Format::Q31 => Op::MulAddHigh { a, b, shift, c },
            Format::Q31Split => Op::MulAddSplit { a, b, shift, c },
            Format::Q15 => Op::MulAddShort { a, b, by: 16 - shift.min(15), c },
            Format::F32 | Format::F32Fma => Op::MulAddF32 { a, b, c, fused: self == Format::F32Fma },
        }
    }

    /// How many truncations a product of this fixed-point format can contain, each of less than a unit.
    pub fn floors(self) -> i64 {
        if self == Format::Q31Split { 3 } else { 1 }
    }

    /// The same for a product by a constant of 31 bits, as the output needs it.
    pub fn scale_high(self, a: Operand, b: Operand, shift: u32) -> Op {
        let c = Operand::Int(0);
        match self {
            Format::Q31 | Format::F32 | Format::F32Fma => Op::MulAddHigh { a, b, shift, c },
            Format::Q31Split | Format::Q15 => Op::MulAddSplit { a, b, shift, c },
        }
    }
}
