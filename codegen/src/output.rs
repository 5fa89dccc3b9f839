//! What a routine returns: the angle in floats, as a power-of-two fraction of its unit, or as a decimal one.

use crate::design::DesignError;
use crate::exact::Interval;
use crate::format::Format;
use crate::program::{Op, Operand, Program, Stage, Type};

/// The format of the result. The unit is the radian for a pair, the sensor's own for a direct one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Output {
    /// `i32`, one unit in 2^bits, with as many bits as the range allows.
    #[cfg_attr(feature = "program", value(name = "pow2"))]
    PowerOfTwo,
    /// `i32`, 10⁻⁹ of the unit.
    Nano,
    /// `i32`, 10⁻⁶ of the unit.
    Micro,
    /// `f32` in the unit.
    F32,
}

impl Output {
    /// The decimal digits of the unit of a decimal output.
    pub fn decimal_digits(self) -> Option<u32> {
        match self {
            Output::Nano => Some(9),
            Output::Micro => Some(6),
            Output::PowerOfTwo | Output::F32 => None,
        }
    }

    /// The finest binary point of the last sum from which this output can still be made.
    pub fn most_fraction_bits(self) -> i64 {
        match self {
            // 10⁹ = 2⁹·5⁹ and 10⁶ = 2⁶·5⁶: beyond, the factor is no integer any more.
            Output::Nano => 41,
            Output::Micro => 38,
            Output::PowerOfTwo | Output::F32 => i64::MAX,
        }
    }

    /// Appends the steps from y·2^−`bits` to the result; gives what one unit of the result stands for.
    ///
    /// # Errors
    /// [`DesignError::Decimal`] where the factor does not fit 32 bits.
    pub fn from_fixed(
        self,
        p: &mut Program,
        format: Format,
        y: Operand,
        bits: i64,
    ) -> Result<Interval, DesignError> {
        let decimal = |p: &mut Program, digits: u32, note: &str| {
            // y·10^digits·2^−bits = ⌊y·m·2⁻³²⌋·2^shift with m = 10^digits·2^(32 − bits − shift).
            let power = Interval::from_int(10i64.pow(digits));
            let shift = (0..8).find(|shift| {
                power.mul_pow2(32 - bits - shift).certainly_le(&Interval::from_int(i64::from(i32::MAX)))
            });
            let error = DesignError::Decimal { digits };
            let shift = shift.ok_or_else(|| error.clone())?;
            let factor = power.mul_pow2(32 - bits - shift);
            let m = factor.floor_to_i64().filter(|m| Interval::from_int(*m) == factor).ok_or(error)?;
            let op = format.scale_high(y, Operand::Int(m), shift as u32);
            p.push(Stage::Output, "angle", Type::I32, op, note);
            Ok(Interval::from_int(1).div(&power))
        };
        match self {
            Output::PowerOfTwo => Ok(Interval::pow2(-bits)),
            Output::Nano => decimal(p, 9, "10⁻⁹"),
            Output::Micro => decimal(p, 6, "10⁻⁶"),
            Output::F32 => {
                let y = p.push(Stage::Output, "angle", Type::F32, Op::ToF32 { a: y }, "");
                let scale = Operand::Float(Interval::pow2(-bits).to_f64() as f32);
                p.push(Stage::Output, "angle", Type::F32, Op::MulF32 { a: y, b: scale }, "exact");
                Ok(Interval::from_int(1))
            }
        }
    }
}
