//! The names by which users ask for formats, cores, inputs and outputs.

use clap::ValueEnum;

use crate::cost::Core;
use crate::format::Format;
use crate::options::{CShift, OutOfRange};
use crate::output::Output;

/// A number format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// 32-bit integers, high words of products.
    Q31,
    /// The same from 16-bit halves, for cores without a long multiplication.
    Q31Split,
    /// 16-bit integers, 32-bit products.
    Q15,
    /// IEEE binary32.
    F32,
}

impl FormatName {
    /// As the library has it.
    pub fn format(self) -> Format {
        match self {
            FormatName::Q31 => Format::Q31,
            FormatName::Q31Split => Format::Q31Split,
            FormatName::Q15 => Format::Q15,
            FormatName::F32 => Format::F32 { fused: false },
        }
    }
}

/// A core.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum CoreName {
    /// ARMv6-M.
    CortexM0,
    /// ARMv7-M.
    CortexM3,
    /// ARMv7E-M with single-precision floats.
    CortexM4f,
}

impl CoreName {
    /// As the library has it.
    pub fn core(self) -> Core {
        match self {
            CoreName::CortexM0 => Core::CortexM0,
            CoreName::CortexM3 => Core::CortexM3,
            CoreName::CortexM4f => Core::CortexM4f,
        }
    }
}

/// What the routines are given.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum InputName {
    /// The reading (s = x₂ − x₁ of a pair) as a float.
    F32,
    /// The reading as a Q31 word.
    Q31,
    /// The reading in counts.
    Counts,
    /// x₁ and x₂ as floats in millimetres.
    X1x2F32,
    /// x₁ and x₂ as Q31 words.
    X1x2Q31,
    /// x₁ and x₂ in counts.
    X1x2Counts,
}

/// What the routines return.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum OutputName {
    /// An integer, a power-of-two fraction of the unit.
    Pow2,
    /// An integer, 10⁻⁹ of the unit: nanoradians.
    Nano,
    /// An integer, 10⁻⁶ of the unit.
    Micro,
    /// A float in the unit.
    F32,
}

/// What happens outside the range.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum OutOfRangeName {
    /// The value at the nearest end.
    Clamp,
    /// The same, and the caller is told.
    Flag,
    /// Nothing: the formula continues there, without a bound but without overflow; saves instructions.
    Continue,
}

/// How C shifts negative numbers.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum CShiftName {
    /// Fully defined by C99.
    Strict,
    /// Arithmetic right shift, checked at compile time.
    Arithmetic,
}

impl OutputName {
    /// As the library has it.
    pub fn output(self) -> Output {
        match self {
            OutputName::Pow2 => Output::PowerOfTwo,
            OutputName::Nano => Output::Nano,
            OutputName::Micro => Output::Micro,
            OutputName::F32 => Output::F32,
        }
    }
}

impl OutOfRangeName {
    /// As the library has it.
    pub fn out_of_range(self) -> OutOfRange {
        match self {
            OutOfRangeName::Clamp => OutOfRange::Clamp,
            OutOfRangeName::Flag => OutOfRange::Flag,
            OutOfRangeName::Continue => OutOfRange::Continue,
        }
    }
}

impl CShiftName {
    /// As the library has it.
    pub fn c_shift(self) -> CShift {
        match self {
            CShiftName::Strict => CShift::Strict,
            CShiftName::Arithmetic => CShift::Arithmetic,
        }
    }
}
