//! What it was a time before, straight between the rows; before the first row it was what it is there.

use super::lowpass::of_time;
use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value, parameters};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError};

static FORM: Form = Form::new(Operation::Delay, "delay", "delay(e, T)", 2..=2);

/// See the module.
pub struct Delay;

impl Operator for Delay {
    fn form(&self) -> &Form {
        &FORM
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        Ok((Quantity::Of(of[0].unit()), vec![1.0, of_time(&of[1])?]))
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        match of[1].from < 0.0 {
            true => Err(format!("the delay runs down to {} s, expected none below zero", of[1].from)),
            false => Ok(of[0]),
        }
    }

    fn value(&self, of: &[Value], time: &Time) -> Value {
        let t_s = time.t_s;
        // The row at or before the delayed moment, and the part of the way to the next.
        let place = |row: usize| {
            let moment = t_s[row] - of[1].at(row);
            let after = t_s[..=row].partition_point(|t| *t <= moment);
            if after == 0 {
                return (0, 0.0, 0.0);
            }
            let from = after - 1;
            match t_s.get(after).map(|next| next - t_s[from]) {
                Some(step) if step > 0.0 => (from, (moment - t_s[from]) / step, step),
                _ => (from, 0.0, 0.0),
            }
        };
        let places: Vec<(usize, f64, f64)> = (0..t_s.len()).map(place).collect();
        let between = |values: &dyn Fn(usize) -> f64, (from, part, step): &(usize, f64, f64)| {
            if *step > 0.0 {
                values(*from) + part * (values(from + 1) - values(*from))
            } else {
                values(*from)
            }
        };
        let value = |row: usize| of[0].at(row);
        let slopes = parameters(of).into_iter().map(|index| {
            let slope = |row: usize| of[0].slope(index, row);
            let at = |(row, place): (usize, &(usize, f64, f64))| {
                let (from, _, step) = *place;
                let rate = if step > 0.0 { (value(from + 1) - value(from)) / step } else { 0.0 };
                between(&slope, place) - rate * of[1].slope(index, row)
            };
            (index, places.iter().enumerate().map(at).collect())
        });
        let slopes = slopes.collect();
        Value { rows: places.iter().map(|place| between(&value, place)).collect(), slopes }
    }

    fn degree(&self, of: &[u32]) -> Option<u32> {
        (of[1] == 0).then_some(of[0])
    }

    fn remembers(&self) -> bool {
        true
    }
}
