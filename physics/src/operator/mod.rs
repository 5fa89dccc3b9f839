//! The operators: each says how many arguments it has, what units they need, its value over the rows with derivatives,
//! the interval of its values, and its text. Every operator takes any expression whose unit fits.

mod arithmetic;
mod delay;
mod elementary;
mod figure;
mod lowpass;
mod play;
mod rate;
mod shapes;
pub mod table;

use std::fmt;
use std::ops::RangeInclusive;

use crate::evaluate::{Time, Value};
use crate::expression::{Expression, binding};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError};

pub use play::ELEMENTS;

pub(crate) use arithmetic::{DIFFERENCE, NEGATIVE, POWER, PRODUCT, QUOTIENT, SUM};
pub(crate) use elementary::{MAX, MIN};

/// Which operator it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // each operator's [`Form`] says how it is written
pub enum Operation {
    Sum,
    Difference,
    Product,
    Quotient,
    Power,
    Negative,
    Abs,
    Sign,
    Min,
    Max,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tanh,
    Hinge,
    Bump,
    Step,
    Table,
    LowPass,
    Rate,
    Delay,
    Play,
    Plays,
    Mean,
    First,
    Lowest,
    Highest,
    Count,
}

impl Operation {
    fn operator(self) -> &'static dyn Operator {
        let all = FUNCTIONS.iter().chain(&SIGNS);
        let own = all.copied().find(|operator| operator.operation() == self);
        own.unwrap_or_else(|| unreachable!("{self:?} is in no list of operators"))
    }

    /// Its name, or its sign.
    pub fn name(self) -> &'static str {
        self.operator().name()
    }

    /// Whether its value depends on the rows before.
    pub fn remembers(self) -> bool {
        self.operator().remembers()
    }

    /// The interval of its values, of arguments in the units that it needs.
    ///
    /// # Errors
    /// A sentence, where a value within the arguments' intervals has none.
    pub fn interval(self, of: &[Interval]) -> Result<Interval, String> {
        self.operator().interval(of)
    }

    /// Its value, of arguments in the units that it needs, and the derivatives by them; of a row alone, so that what
    /// remembers has its value at a first row.
    pub fn at(self, x: &[f64]) -> (f64, Vec<f64>) {
        let own = |(index, x): (usize, &f64)| Value { rows: vec![*x], slopes: vec![(index, vec![1.0])] };
        let of: Vec<Value> = x.iter().enumerate().map(own).collect();
        let value = self.operator().value(&of, &Time { t_s: &[0.0], pass: &[0] });
        (value.at(0), (0..x.len()).map(|index| value.slope(index, 0)).collect())
    }
}

/// What an operator is called, and how it is written.
pub struct Form {
    /// Which it is.
    pub operation: Operation,
    /// Its name, or its sign.
    pub name: &'static str,
    /// How it is written.
    pub usage: &'static str,
    /// How many arguments it takes.
    pub arguments: RangeInclusive<usize>,
}

impl Form {
    const fn new(
        operation: Operation,
        name: &'static str,
        usage: &'static str,
        arguments: RangeInclusive<usize>,
    ) -> Form {
        Form { operation, name, usage, arguments }
    }
}

/// One operator of the language.
pub trait Operator: Sync {
    /// What it is called, and how it is written.
    fn form(&self) -> &Form;
    /// Which it is.
    fn operation(&self) -> Operation {
        self.form().operation
    }
    /// Its name, or its sign.
    fn name(&self) -> &'static str {
        self.form().name
    }
    /// The unit of its value, and by what each argument is multiplied first, so that units agree.
    ///
    /// # Errors
    /// Which units do not go together.
    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError>;
    /// The interval of its values.
    ///
    /// # Errors
    /// A sentence, where a value within the arguments' intervals has none.
    fn interval(&self, of: &[Interval]) -> Result<Interval, String>;
    /// The same of a figure of a column, given the least and the largest value that the column has; none of others.
    fn interval_of_column(&self, _: Interval) -> Option<Interval> {
        None
    }
    /// Its value at every row, with the derivatives by the parameters.
    fn value(&self, of: &[Value], time: &Time) -> Value;
    /// Its value of the values at one instant, the derivatives by them being written; NaN of what remembers.
    fn at(&self, _: &[f64], _: &mut [f64]) -> f64 {
        f64::NAN
    }
    /// How it depends on factors, of which the arguments hold these powers; none where no power describes it.
    fn degree(&self, of: &[u32]) -> Option<u32> {
        of.iter().all(|degree| *degree == 0).then_some(0)
    }
    /// Whether its value depends on the rows before.
    fn remembers(&self) -> bool {
        false
    }
    /// Whether it is one figure of a whole recording.
    fn of_recording(&self) -> bool {
        false
    }
    /// How tightly its text holds together.
    fn binding(&self) -> u8 {
        binding::WHOLE
    }
    /// Its text.
    ///
    /// # Errors
    /// Those of the formatter.
    fn write(&self, of: &[Expression], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let arguments: Vec<String> = of.iter().map(ToString::to_string).collect();
        write!(f, "{}({})", self.name(), arguments.join(", "))
    }
}

/// All operators that are written as signs.
static SIGNS: [&dyn Operator; 6] = [SUM, DIFFERENCE, PRODUCT, QUOTIENT, POWER, NEGATIVE];

/// All operators that are written as functions.
pub static FUNCTIONS: [&dyn Operator; 24] = [
    &elementary::ABS,
    &elementary::SIGN,
    &elementary::MIN,
    &elementary::MAX,
    &elementary::SQRT,
    &elementary::EXP,
    &elementary::LOG,
    &elementary::SIN,
    &elementary::COS,
    &elementary::TANH,
    &shapes::HINGE,
    &shapes::BUMP,
    &shapes::STEP,
    &table::Table,
    &lowpass::LowPass,
    &rate::Rate,
    &delay::Delay,
    &play::PLAY,
    &play::PLAYS,
    &figure::MEAN,
    &figure::FIRST,
    &figure::LOWEST,
    &figure::HIGHEST,
    &figure::COUNT,
];

/// The function of a name.
pub fn function(name: &str) -> Option<&'static dyn Operator> {
    FUNCTIONS.iter().copied().find(|operator| operator.name() == name)
}
