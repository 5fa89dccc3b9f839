//! Values over the rows of a recording, with their derivatives by the parameters.

use std::borrow::Cow;

use crate::check::{Applied, Node, Sentence};

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
    fn times(mut self, factor: f64) -> Value {
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

/// A function of the values of one row: `function` returns its value and writes its derivatives by the arguments.
pub(crate) fn pointwise(of: &[Value], function: impl Fn(&[f64], &mut [f64]) -> f64) -> Value {
    let parameters = parameters(of);
    let count = of.iter().map(|value| value.rows.len()).max().unwrap_or(1);
    let mut rows = Vec::with_capacity(count);
    let mut slopes: Vec<(usize, Vec<f64>)> =
        parameters.iter().map(|index| (*index, Vec::with_capacity(count))).collect();
    let (mut x, mut partial) = ([0.0; MOST_ARGUMENTS], [0.0; MOST_ARGUMENTS]);
    for row in 0..count {
        for (x, value) in x.iter_mut().zip(of) {
            *x = value.at(row);
        }
        rows.push(function(&x[..of.len()], &mut partial[..of.len()]));
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
        evaluate(&self.root, columns, values)
    }
}

fn evaluate(node: &Node, columns: &dyn Columns, values: &[f64]) -> Result<Value, String> {
    Ok(match node {
        Node::Constant(value) => Value::constant(*value),
        Node::Column(name) => {
            let rows = columns.column(name).ok_or_else(|| name.clone())?.into_owned();
            Value { rows, slopes: Vec::new() }
        }
        Node::Parameter(index) => Value { rows: vec![values[*index]], slopes: vec![(*index, vec![1.0])] },
        Node::Apply(Applied { operator, arguments, .. }) => {
            let of = arguments
                .iter()
                .map(|(argument, factor)| Ok(evaluate(argument, columns, values)?.times(*factor)));
            operator.value(&of.collect::<Result<Vec<_>, String>>()?, &columns.time())
        }
    })
}
