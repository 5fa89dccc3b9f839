//! Sums, products, quotients, powers and signs.

use std::fmt;

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value, pointwise};
use crate::expression::{Expression, binding};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};

/// An operator between two operands, or before one.
struct Arithmetic {
    kind: Kind,
    form: Form,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sum,
    Difference,
    Product,
    Quotient,
    Power,
    Negative,
}

const fn arithmetic(kind: Kind, operation: Operation, sign: &'static str, usage: &'static str) -> Arithmetic {
    let operands = if matches!(kind, Kind::Negative) { 1 } else { 2 };
    Arithmetic { kind, form: Form::new(operation, sign, usage, operands..=operands) }
}

pub static SUM: &dyn Operator = &arithmetic(Kind::Sum, Operation::Sum, "+", "a + b");
pub static DIFFERENCE: &dyn Operator = &arithmetic(Kind::Difference, Operation::Difference, "-", "a - b");
pub static PRODUCT: &dyn Operator = &arithmetic(Kind::Product, Operation::Product, "*", "a * b");
pub static QUOTIENT: &dyn Operator = &arithmetic(Kind::Quotient, Operation::Quotient, "/", "a / b");
pub static POWER: &dyn Operator = &arithmetic(Kind::Power, Operation::Power, "^", "a ^ 2");
pub static NEGATIVE: &dyn Operator = &arithmetic(Kind::Negative, Operation::Negative, "-", "-a");

/// `x` to a power, a whole one wherever it is.
fn power(x: f64, exponent: f64) -> f64 {
    if exponent == exponent.round() && exponent.abs() <= f64::from(i16::MAX) {
        x.powi(exponent as i32)
    } else {
        x.powf(exponent)
    }
}

impl Operator for Arithmetic {
    fn form(&self) -> &Form {
        &self.form
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        let plain = |unit| (unit, vec![1.0; of.len()]);
        // Numbers alone make a number.
        if let Some(numbers) = of.iter().map(Quantity::number).collect::<Option<Vec<f64>>>() {
            return Ok(plain(Quantity::Number(self.at(&numbers, &mut [0.0; 2]))));
        }
        Ok(match self.kind {
            Kind::Sum | Kind::Difference | Kind::Negative => return common(of),
            Kind::Product => plain(Quantity::Of(of[0].unit().times(&of[1].unit()))),
            Kind::Quotient => {
                let below = of[1].unit().power(-1.0).ok_or(UnitError::Exponent)?;
                plain(Quantity::Of(of[0].unit().times(&below)))
            }
            Kind::Power => {
                let exponent = of[1].number().ok_or(UnitError::Exponent)?;
                plain(Quantity::Of(of[0].unit().power(exponent).ok_or(UnitError::Exponent)?))
            }
        })
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        let a = of[0];
        Ok(match self.kind {
            Kind::Sum => Interval { from: a.from + of[1].from, to: a.to + of[1].to },
            Kind::Difference => Interval { from: a.from - of[1].to, to: a.to - of[1].from },
            Kind::Negative => Interval { from: -a.to, to: -a.from },
            Kind::Product => Interval::corners(a, of[1], |a, b| a * b),
            Kind::Quotient => {
                if of[1].holds(0.0) {
                    let Interval { from, to } = of[1];
                    return Err(format!("the divisor runs from {from} to {to}, and can be zero"));
                }
                Interval::corners(a, of[1], |a, b| a / b)
            }
            Kind::Power => {
                let exponent = of[1].from;
                let whole = exponent == exponent.round();
                if !whole && a.from < 0.0 {
                    return Err(format!("a value down to {} has no power of {exponent}", a.from));
                }
                if exponent < 0.0 && a.holds(0.0) {
                    return Err(format!(
                        "a value from {} to {} can be zero under a negative power",
                        a.from, a.to
                    ));
                }
                let ends = [power(a.from, exponent), power(a.to, exponent)];
                let middle = if a.holds(0.0) { power(0.0, exponent) } else { ends[0] };
                Interval { from: ends[0].min(ends[1]).min(middle), to: ends[0].max(ends[1]).max(middle) }
            }
        })
    }

    fn value(&self, of: &[Value], _: &Time) -> Value {
        let slopes = |x: &[f64], slopes: &mut [f64]| self.slopes(x, slopes);
        match self.kind {
            Kind::Sum => pointwise(of, |x| x[0] + x[1], slopes),
            Kind::Difference => pointwise(of, |x| x[0] - x[1], slopes),
            Kind::Product => pointwise(of, |x| x[0] * x[1], slopes),
            Kind::Quotient => pointwise(of, |x| x[0] / x[1], slopes),
            Kind::Power => pointwise(of, |x| power(x[0], x[1]), slopes),
            Kind::Negative => pointwise(of, |x| -x[0], slopes),
        }
    }

    fn at(&self, x: &[f64], slopes: &mut [f64]) -> f64 {
        self.slopes(x, slopes);
        match self.kind {
            Kind::Sum => x[0] + x[1],
            Kind::Difference => x[0] - x[1],
            Kind::Product => x[0] * x[1],
            Kind::Quotient => x[0] / x[1],
            Kind::Power => power(x[0], x[1]),
            Kind::Negative => -x[0],
        }
    }

    fn degree(&self, of: &[u32]) -> Option<u32> {
        match self.kind {
            Kind::Sum | Kind::Difference => (of[0] == of[1]).then_some(of[0]),
            Kind::Negative => Some(of[0]),
            Kind::Product => Some(of[0] + of[1]),
            Kind::Quotient | Kind::Power => {
                (of[1] == 0 && (self.kind == Kind::Quotient || of[0] == 0)).then_some(of[0])
            }
        }
    }

    fn binding(&self) -> u8 {
        match self.kind {
            Kind::Sum | Kind::Difference => binding::SUM,
            Kind::Product | Kind::Quotient => binding::PRODUCT,
            Kind::Power => binding::POWER,
            Kind::Negative => binding::SIGN,
        }
    }

    fn write(&self, of: &[Expression], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = self.binding();
        match self.kind {
            Kind::Negative => write!(f, "-{}", of[0].within(own)),
            Kind::Power => write!(f, "{}^{}", of[0].within(own + 1), of[1].within(own)),
            // Equal ones are read from left to right.
            _ => write!(f, "{} {} {}", of[0].within(own), self.form.name, of[1].within(own + 1)),
        }
    }
}

impl Arithmetic {
    /// Writes the derivatives by the operands.
    fn slopes(&self, x: &[f64], slopes: &mut [f64]) {
        let a = x[0];
        match self.kind {
            Kind::Sum => slopes[..2].copy_from_slice(&[1.0, 1.0]),
            Kind::Difference => slopes[..2].copy_from_slice(&[1.0, -1.0]),
            Kind::Product => slopes[..2].copy_from_slice(&[x[1], a]),
            Kind::Quotient => slopes[..2].copy_from_slice(&[1.0 / x[1], -a / (x[1] * x[1])]),
            Kind::Power => slopes[..2].copy_from_slice(&[x[1] * power(a, x[1] - 1.0), 0.0]),
            Kind::Negative => slopes[0] = -1.0,
        }
    }
}
