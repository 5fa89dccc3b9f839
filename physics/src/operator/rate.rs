//! The rate of change: the difference to the row before in the same pass, as a controller forms it. The first row of a
//! pass has the rate of the second.

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError};
use crate::unit::Unit;

static FORM: Form = Form::new(Operation::Rate, "rate", "rate(e)", 1..=1);

/// See the module.
pub struct Rate;

impl Operator for Rate {
    fn form(&self) -> &Form {
        &FORM
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        let per_second = Unit::named("s").power(-1.0).ok_or(UnitError::Exponent)?;
        Ok((Quantity::Of(of[0].unit().times(&per_second)), vec![1.0]))
    }

    fn interval(&self, _: &[Interval]) -> Result<Interval, String> {
        // The rows say how fast it was; nothing says how fast it may be.
        Ok(Interval { from: f64::NEG_INFINITY, to: f64::INFINITY })
    }

    fn value(&self, of: &[Value], time: &Time) -> Value {
        let Time { t_s, pass } = time;
        let count = t_s.len();
        let same = |a: usize, b: usize| b < count && pass[a] == pass[b];
        let rates = |values: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let between = |a: usize, b: usize| {
                let passed = t_s[b] - t_s[a];
                if passed > 0.0 { (values(b) - values(a)) / passed } else { 0.0 }
            };
            let at = |row: usize| match row {
                _ if row > 0 && same(row - 1, row) => between(row - 1, row),
                _ if same(row, row + 1) => between(row, row + 1),
                _ => 0.0,
            };
            (0..count).map(at).collect()
        };
        let slopes = of[0].slopes.iter().map(|(index, _)| (*index, rates(&|row| of[0].slope(*index, row))));
        Value { rows: rates(&|row| of[0].at(row)), slopes: slopes.collect() }
    }

    fn degree(&self, of: &[u32]) -> Option<u32> {
        Some(of[0])
    }

    fn remembers(&self) -> bool {
        true
    }
}
