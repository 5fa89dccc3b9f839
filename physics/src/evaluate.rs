//! Values over the rows of a recording, with their derivatives by the parameters.

use std::borrow::Cow;
use std::ops::Range;

use crate::check::{Applied, Node, Sentence};
use crate::unit::Unit;

/// Most arguments of an operator.
const MOST_ARGUMENTS: usize = 4;

/// One value per row, or one for all, with derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// One per row; a single one holds for all.
    pub rows: Vec<f64>,
    /// Derivative by a parameter, of the parameters that it depends on: by index, ascending.
    pub slopes: Vec<(usize, Vec<f64>)>,
}

/// When the rows were read.
#[derive(Debug, Clone, Copy)]
pub struct Time<'a> {
    /// Seconds.
    pub t_s: &'a [f64],
    /// Number of the pass of each row; memory goes on from pass to pass, a rate does not.
    pub pass: &'a [i64],
}

/// What an expression reads of a recording.
pub trait Columns {
    /// The values of a column, one per row.
    fn column(&self, name: &str) -> Option<Cow<'_, [f64]>>;
    /// When the rows were read.
    fn time(&self) -> Time<'_>;
}

impl Value {
    /// The same for all rows.
    pub fn constant(value: f64) -> Value {
        Value { rows: vec![value], slopes: Vec::new() }
    }

    /// At a row.
    pub fn at(&self, row: usize) -> f64 {
        at(&self.rows, row)
    }

    /// Its derivative by a parameter at a row.
    pub fn slope(&self, parameter: usize, row: usize) -> f64 {
        self.slopes.iter().find(|(index, _)| *index == parameter).map_or(0.0, |(_, slopes)| at(slopes, row))
    }

    /// Multiplied by a number.
    pub(crate) fn times(mut self, factor: f64) -> Value {
        if factor != 1.0 {
            let columns = self.slopes.iter_mut().map(|(_, slopes)| slopes).chain([&mut self.rows]);
            columns.flatten().for_each(|value| *value *= factor);
        }
        self
    }
}

fn at(values: &[f64], row: usize) -> f64 {
    if values.len() == 1 { values[0] } else { values[row] }
}

/// The parameters that any of the values depends on.
pub(crate) fn parameters(of: &[Value]) -> Vec<usize> {
    let mut all: Vec<usize> =
        of.iter().flat_map(|value| value.slopes.iter().map(|(index, _)| *index)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// A function of the values of one row, with the function that writes its derivatives by the arguments.
pub(crate) fn pointwise(
    of: &[Value],
    at: impl Fn(&[f64]) -> f64,
    derivatives: impl Fn(&[f64], &mut [f64]),
) -> Value {
    let count = of.iter().map(|value| value.rows.len()).max().unwrap_or(1);
    let (mut x, mut partial) = ([0.0; MOST_ARGUMENTS], [0.0; MOST_ARGUMENTS]);
    let fill = |x: &mut [f64; MOST_ARGUMENTS], row: usize| {
        x.iter_mut().zip(of).for_each(|(x, value)| *x = value.at(row));
    };
    let rows = match of {
        [a] => a.rows.iter().map(|a| at(&[*a])).collect(),
        [a, b] if b.rows.len() == 1 => {
            let b = b.rows[0];
            a.rows.iter().map(|a| at(&[*a, b])).collect()
        }
        [a, b] if a.rows.len() == 1 => {
            let a = a.rows[0];
            b.rows.iter().map(|b| at(&[a, *b])).collect()
        }
        [a, b, c] if b.rows.len() == 1 && c.rows.len() == 1 => {
            let (b, c) = (b.rows[0], c.rows[0]);
            a.rows.iter().map(|a| at(&[*a, b, c])).collect()
        }
        [a, b] if a.rows.len() == b.rows.len() => {
            a.rows.iter().zip(&b.rows).map(|(a, b)| at(&[*a, *b])).collect()
        }
        _ => (0..count)
            .map(|row| {
                fill(&mut x, row);
                at(&x[..of.len()])
            })
            .collect(),
    };
    let parameters = parameters(of);
    let mut slopes: Vec<(usize, Vec<f64>)> =
        parameters.iter().map(|index| (*index, Vec::with_capacity(count))).collect();
    for row in 0..if slopes.is_empty() { 0 } else { count } {
        fill(&mut x, row);
        derivatives(&x[..of.len()], &mut partial[..of.len()]);
        for (index, slopes) in &mut slopes {
            let sum = of.iter().zip(&partial).map(|(value, partial)| match value.slope(*index, row) {
                0.0 => 0.0,
                slope => partial * slope,
            });
            slopes.push(sum.sum());
        }
    }
    Value { rows, slopes }
}

impl Sentence {
    /// Its value at every row, in its unit, and the derivatives by the parameters at these `values`.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn evaluate(&self, columns: &dyn Columns, values: &[f64]) -> Result<Value, String> {
        self.root.value(columns, values, true)
    }

    /// Its value at every row, in its unit; a single one holds for all.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn values(&self, columns: &dyn Columns, values: &[f64]) -> Result<Vec<f64>, String> {
        Ok(self.root.value(columns, values, false)?.rows)
    }

    /// Its text with a number in place of every figure of the recording.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn settled(&self, columns: &dyn Columns, values: &[f64]) -> Result<String, String> {
        let mut text = self.text.clone();
        let mut figures = Vec::new();
        self.root.figures(&mut figures);
        // From the end, so that the places before stay.
        figures.sort_by_key(|(span, ..)| std::cmp::Reverse(span.start));
        for (span, figure, unit) in figures {
            let value = figure.value(columns, values, false)?.at(0);
            let number = if unit.is_one() { format!("{value}") } else { format!("{value} [{unit}]") };
            text.replace_range(span, &if value < 0.0 { format!("({number})") } else { number });
        }
        Ok(text)
    }
}

impl Node {
    /// Its value at every row, with the derivatives by the parameters where `derivatives` are wanted.
    ///
    /// # Errors
    /// The name of a column that is missing.
    pub fn value(&self, columns: &dyn Columns, values: &[f64], derivatives: bool) -> Result<Value, String> {
        Ok(match self {
            Node::Constant(value) => Value::constant(*value),
            Node::Column(name) => {
                let rows = columns.column(name).ok_or_else(|| name.clone())?.into_owned();
                Value { rows, slopes: Vec::new() }
            }
            Node::Parameter(index) if derivatives => {
                Value { rows: vec![values[*index]], slopes: vec![(*index, vec![1.0])] }
            }
            Node::Parameter(index) => Value::constant(values[*index]),
            Node::Apply(Applied { operator, arguments, .. }) if !derivatives && operator.name() == "*" => {
                let of = |k: usize| -> Result<Value, String> {
                    Ok(arguments[k].0.value(columns, values, false)?.times(arguments[k].1))
                };
                // What is multiplied by nothing need not be known.
                match of(0)? {
                    first if first.rows[..] == [0.0] => first,
                    first if first.rows.len() == 1 => of(1)?.times(first.at(0)),
                    first => operator.value(&[first, of(1)?], &columns.time()),
                }
            }
            Node::Apply(Applied { operator, arguments, .. }) => {
                let of = arguments.iter().map(|(argument, factor)| {
                    Ok(argument.value(columns, values, derivatives)?.times(*factor))
                });
                operator.value(&of.collect::<Result<Vec<_>, String>>()?, &columns.time())
            }
        })
    }

    /// The largest parts of it that are computed of figures of the recording alone, with their places and units.
    fn figures<'a>(&'a self, found: &mut Vec<(Range<usize>, &'a Node, &'a Unit)>) {
        if let Node::Apply(Applied { arguments, span, unit, .. }) = self {
            match unit {
                Some(unit) => found.push((span.clone(), self, unit)),
                None => arguments.iter().for_each(|(argument, _)| argument.figures(found)),
            }
        }
    }
}

impl Applied {
    /// Whether it is one number of the recording: a figure, or computed of figures and constants.
    pub(crate) fn is_figure(&self) -> bool {
        let is_figure =
            |(node, _): &(Node, f64)| matches!(node, Node::Apply(applied) if applied.unit.is_some());
        let is_number =
            |argument: &(Node, f64)| matches!(argument.0, Node::Constant(_)) || is_figure(argument);
        self.operator.of_recording()
            || (self.arguments.iter().all(is_number) && self.arguments.iter().any(is_figure))
    }
}
