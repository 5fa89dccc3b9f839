//! Figures of a whole recording: one number for all rows. Where an expression is handed on, the number stands for it.

use std::borrow::Cow;

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};
use crate::unit::Unit;

/// See the module.
pub struct Figure {
    form: Form,
    /// Of the values at all rows.
    of: fn(&[f64]) -> f64,
    /// Its derivative, of the values and of theirs.
    slope: fn(&[f64], &[f64]) -> f64,
    /// Of a column, given the least and the largest value that it has.
    of_range: fn(Interval) -> Interval,
    /// Whether it is a number of rows.
    counts: bool,
}

pub static MEAN: Figure = Figure {
    form: Form::new(Operation::Mean, "mean", "mean(e), over all rows", 1..=1),
    of: mean,
    slope: |_, slopes| mean(slopes),
    of_range: |range| range,
    counts: false,
};

pub static FIRST: Figure = Figure {
    form: Form::new(Operation::First, "first", "first(e), at the first row", 1..=1),
    of: |rows| rows[0],
    slope: |_, slopes| slopes[0],
    of_range: |range| range,
    counts: false,
};

pub static LOWEST: Figure = Figure {
    form: Form::new(Operation::Lowest, "lowest", "lowest(e), over all rows", 1..=1),
    of: |rows| rows.iter().copied().fold(f64::INFINITY, f64::min),
    slope: |rows, slopes| slopes[place(rows, |a, b| a < b)],
    of_range: |range| Interval::point(range.from),
    counts: false,
};

pub static HIGHEST: Figure = Figure {
    form: Form::new(Operation::Highest, "highest", "highest(e), over all rows", 1..=1),
    of: |rows| rows.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    slope: |rows, slopes| slopes[place(rows, |a, b| a > b)],
    of_range: |range| Interval::point(range.to),
    counts: false,
};

pub static COUNT: Figure = Figure {
    form: Form::new(Operation::Count, "count", "count(e), of the rows at which e is positive", 1..=1),
    of: |rows| rows.iter().filter(|value| **value > 0.0).count() as f64,
    slope: |_, _| 0.0,
    of_range: |_| NUMBER_OF_ROWS,
    counts: true,
};

const NUMBER_OF_ROWS: Interval = Interval { from: 0.0, to: f64::INFINITY };

fn mean(rows: &[f64]) -> f64 {
    rows.iter().sum::<f64>() / rows.len() as f64
}

/// The first of the rows that is `beyond` all others.
fn place(rows: &[f64], beyond: fn(f64, f64) -> bool) -> usize {
    (1..rows.len()).fold(0, |best, row| if beyond(rows[row], rows[best]) { row } else { best })
}

impl Operator for Figure {
    fn form(&self) -> &Form {
        &self.form
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        if self.counts { Ok((Quantity::Of(Unit::one()), vec![1.0])) } else { common(of) }
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        Ok(if self.counts { NUMBER_OF_ROWS } else { of[0] })
    }

    fn interval_of_column(&self, range: Interval) -> Option<Interval> {
        Some((self.of_range)(range))
    }

    fn value(&self, of: &[Value], time: &Time) -> Value {
        let rows = time.t_s.len();
        if rows == 0 {
            return Value::constant(f64::NAN);
        }
        let all = match &of[0].rows[..] {
            [one] => Cow::Owned(vec![*one; rows]),
            all => Cow::Borrowed(all),
        };
        let slope = |index: usize| {
            let slopes: Vec<f64> = (0..rows).map(|row| of[0].slope(index, row)).collect();
            vec![(self.slope)(&all, &slopes)]
        };
        let slopes = of[0].slopes.iter().map(|(index, _)| (*index, slope(*index)));
        Value { rows: vec![(self.of)(&all)], slopes: slopes.collect() }
    }

    fn of_recording(&self) -> bool {
        true
    }
}
