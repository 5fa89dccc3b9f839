//! Number formats of the evaluation.

use crate::cost::Core;
use crate::exact::Interval;
use crate::program::{Op, Operand};

fitter::errors! {
    /// Why products and sums of floats cannot be rounded once together.
    #[derive(Debug, Clone, PartialEq)]
    pub enum NotFused {
        NoFloats => says("a fused multiply-add belongs to floats") mend("add the format f32, or leave it out") by_name("fma");
        NoInstruction { core: &'static str } =>
            says("{core} has no fused multiply-add: every one would be a call") mend("leave it out") by_name("fma");
    }
}

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

    /// Whether routines of these formats can have it, or one of any format that is chosen for a core.
    ///
    /// # Errors
    /// [`NotFused`], with the reason.
    pub fn can_fuse(formats: &[Format], target: Option<Core>) -> Result<(), NotFused> {
        match target {
            Some(core) if !core.fuses() => Err(NotFused::NoInstruction { core: core.name() }),
            None if !formats.iter().any(|format| !format.is_fixed()) => Err(NotFused::NoFloats),
            _ => Ok(()),
        }
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

    /// How far a product a·b of this fixed-point format lies below the exact one, in its own units: the middle, and the most
    /// to either side of it, for every b.
    pub fn lost(self, a: &Interval) -> (Interval, Interval) {
        let half = Interval::pow2(-1);
        if self != Format::Q31Split {
            return (half.clone(), half);
        }
        // The floor, the odd half of b₁ times a₀, and a₀b₀ take 0…1 each; the odd half of b₀ takes or gives |a₁|·2⁻¹⁶.
        let middle = Interval::from_int(3).mul_pow2(-1);
        let odd = (&a.magnitude() + &Interval::pow2(16)).mul_pow2(-32).upper();
        (middle.clone(), &middle + &odd)
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
