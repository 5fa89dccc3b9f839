//! The names by which users ask for formats and inputs.

use clap::ValueEnum;

use crate::format::Format;

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
