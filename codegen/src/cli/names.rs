//! The names by which users ask for formats, cores, inputs and outputs.

use clap::ValueEnum;

use crate::cost::Core;
use crate::format::Format;
use crate::options::{CShift, OutOfRange};
use crate::output::Output;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum FormatName {
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
    pub(super) fn format(self) -> Format {
        match self {
            FormatName::Q31 => Format::Q31,
            FormatName::Q31Split => Format::Q31Split,
            FormatName::Q15 => Format::Q15,
            FormatName::F32 => Format::F32 { fused: false },
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum CoreName {
    /// ARMv6-M.
    CortexM0,
    /// ARMv7-M.
    CortexM3,
    /// ARMv7E-M with single-precision floats.
    CortexM4f,
}

impl CoreName {
    pub(super) fn core(self) -> Core {
        match self {
            CoreName::CortexM0 => Core::CortexM0,
            CoreName::CortexM3 => Core::CortexM3,
            CoreName::CortexM4f => Core::CortexM4f,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum InputName {
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

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum OutputName {
    /// An integer, a power-of-two fraction of the unit.
    Pow2,
    /// An integer, 10⁻⁹ of the unit: nanoradians.
    Nano,
    /// An integer, 10⁻⁶ of the unit.
    Micro,
    /// A float in the unit.
    F32,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum OutOfRangeName {
    /// The value at the nearest end.
    Clamp,
    /// The same, and the caller is told.
    Flag,
    /// Nothing: the formula continues there, without a bound but without overflow; saves instructions.
    Continue,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum CShiftName {
    /// Fully defined by C99.
    Strict,
    /// Arithmetic right shift, checked at compile time.
    Arithmetic,
}

impl OutputName {
    pub(super) fn output(self) -> Output {
        match self {
            OutputName::Pow2 => Output::PowerOfTwo,
            OutputName::Nano => Output::Nano,
            OutputName::Micro => Output::Micro,
            OutputName::F32 => Output::F32,
        }
    }
}

impl OutOfRangeName {
    pub(super) fn out_of_range(self) -> OutOfRange {
        match self {
            OutOfRangeName::Clamp => OutOfRange::Clamp,
            OutOfRangeName::Flag => OutOfRange::Flag,
            OutOfRangeName::Continue => OutOfRange::Continue,
        }
    }
}

impl CShiftName {
    pub(super) fn c_shift(self) -> CShift {
        match self {
            CShiftName::Strict => CShift::Strict,
            CShiftName::Arithmetic => CShift::Arithmetic,
        }
    }
}
