//! A table: straight lines through values at even places of a quantity, held beyond the first and the last.

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value, parameters};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};

/// Arguments before the values: the quantity, and the places of the first and the last value.
const BEFORE: usize = 3;
/// Most values.
const MOST: usize = 64;

static FORM: Form = Form::new(
    Operation::Table,
    "table",
    "table(e, from, to, v0, v1, ...), of 2 to 64 values at even places",
    BEFORE + 2..=BEFORE + MOST,
);

/// See the module.
pub struct Table;

/// Between which two values a quantity lies.
struct Place {
    /// The first of them.
    first: usize,
    /// The part of the way to the second.
    part: f64,
    /// Whether it is held there.
    held: bool,
}

impl Place {
    /// Of `x` in a table of so many `steps`.
    fn of(x: f64, from: f64, to: f64, steps: usize) -> Place {
        let along = (x - from) / (to - from) * steps as f64;
        if along <= 0.0 {
            Place { first: 0, part: 0.0, held: true }
        } else if along >= steps as f64 {
            Place { first: steps - 1, part: 1.0, held: true }
        } else {
            let first = along as usize;
            Place { first, part: along - first as f64, held: false }
        }
    }
}

/// The steepest slope of a table by its quantity, of its arguments.
pub fn steepest(of: &[f64]) -> f64 {
    let steps = of.len() - BEFORE - 1;
    let largest = of[BEFORE..].windows(2).fold(0.0, |most: f64, pair| most.max((pair[1] - pair[0]).abs()));
    largest * steps as f64 / (of[2] - of[1])
}

/// The places of a table's values, of its arguments.
pub fn places(of: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let steps = of.len() - BEFORE - 1;
    (0..=steps).map(move |k| of[1] + (of[2] - of[1]) * k as f64 / steps as f64)
}

impl Operator for Table {
    fn form(&self) -> &Form {
        &FORM
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        let (_, mut factors) = common(&of[..BEFORE])?;
        let (unit, of_values) = common(&of[BEFORE..])?;
        factors.extend(of_values);
        Ok((unit, factors))
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        if of[2].from <= of[1].to {
            return Err(format!(
                "the table runs from {} at most to {} at least, expected an end above the beginning",
                of[1].to, of[2].from
            ));
        }
        let values = &of[BEFORE..];
        Ok(Interval {
            from: values.iter().map(|value| value.from).fold(f64::INFINITY, f64::min),
            to: values.iter().map(|value| value.to).fold(f64::NEG_INFINITY, f64::max),
        })
    }

    fn value(&self, of: &[Value], _: &Time) -> Value {
        let count = of.iter().map(|value| value.rows.len()).max().unwrap_or(1);
        let (ends, values) = (&of[1..BEFORE], &of[BEFORE..]);
        let steps = values.len() - 1;
        let place = |row: usize| Place::of(of[0].at(row), ends[0].at(row), ends[1].at(row), steps);
        let places: Vec<Place> = (0..count).map(place).collect();
        let between = |Place { first, part, .. }: &Place, value: &dyn Fn(&Value) -> f64| {
            let [a, b] = [*first, first + 1].map(|k| value(&values[k]));
            a + part * (b - a)
        };
        let rows = places.iter().enumerate().map(|(row, place)| between(place, &|value| value.at(row)));
        let rows = rows.collect();
        let slopes = parameters(of).into_iter().map(|index| {
            let at = |(row, place): (usize, &Place)| {
                let by_values = between(place, &|value| value.slope(index, row));
                if place.held {
                    return by_values;
                }
                let [from, to] = [0, 1].map(|k| ends[k].at(row));
                let [x, d_from, d_to] = [0, 1, 2].map(|k| of[k].slope(index, row));
                // The part of the way from one end to the other, and how it moves.
                let way = (of[0].at(row) - from) / (to - from);
                let moved = (x - (1.0 - way) * d_from - way * d_to) / (to - from);
                let rise = values[place.first + 1].at(row) - values[place.first].at(row);
                by_values + rise * steps as f64 * moved
            };
            (index, places.iter().enumerate().map(at).collect())
        });
        let slopes = slopes.collect();
        Value { rows, slopes }
    }

    fn degree(&self, of: &[u32]) -> Option<u32> {
        let (before, values) = of.split_at(BEFORE);
        let alike = values.iter().all(|degree| *degree == values[0]);
        (alike && before.iter().all(|degree| *degree == 0)).then_some(values[0])
    }
}
