//! The physical effects that can stand between a recording and its simulation: the catalogue, which is a file of
//! declarations, and those that a user declares. An effect's contribution is linear in its amplitudes and may depend on a
//! few shape parameters (time constants, periods, thresholds, …) that the search finds.

mod composed;
pub mod declared;
mod effect;
mod grid;
mod needs;
mod operators;
mod over;
pub mod page;
mod read;
mod read_once;
mod report;
mod term;
mod unsettled;

pub use composed::{composed, curves};
pub use effect::Effect;
pub use operators::{low_pass, play_from};
pub use over::Over;
pub(crate) use read::Read;

use std::sync::Arc;

use fitter::error_model::Sensor;
use fitter::terms::Operator;
use read_once::ReadOnce;

pub use crate::experiment::Experiment;
use crate::rows::Rows;

/// Where a mismatch lives: an observable, or an observable times another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name of the observable as in `locations`.
    pub variable: String,
    /// The observable that multiplies it, where it is a product.
    pub times: Option<String>,
}

impl Place {
    /// The place of a plain dependence.
    pub fn on(variable: &str) -> Place {
        Place { variable: variable.into(), times: None }
    }

    /// The place of a product.
    pub fn product(variable: &str, times: &str) -> Place {
        Place { variable: variable.into(), times: Some(times.into()) }
    }
}

/// A shape parameter's range.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Whether it is searched on a logarithmic scale.
    pub logarithmic: bool,
    /// Whether it only takes whole values (a row, a number of harmonics).
    pub whole: bool,
}

/// What is reported of one parameter.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Its name in the diagnosis, with its unit.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// Who says that there is such an effect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The catalogue.
    Catalogue,
    /// The user.
    User,
    /// No one: it is a form that a dependence may have, with how it would be declared as an effect.
    Form(String),
}

/// What an effect does with the common mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommonMode {
    /// Nothing of the following.
    Otherwise,
    /// It depends on no other column, and on no past of this one.
    Alone,
    /// It depends on its past.
    Remembered,
}

/// What is known of an effect beside its expressions.
#[derive(Debug)]
pub struct Facts {
    /// Identifier in the diagnosis and the coefficients file.
    pub id: String,
    /// Name for a reader.
    pub title: String,
    /// What it adds to the angular error.
    pub formula: String,
    /// Where the physics is described.
    pub source: String,
    /// Sign and magnitude that are plausible.
    pub size: String,
    /// Ids of the effects that it is most easily taken for.
    pub confused_with: Vec<String>,
    /// Where the mismatch that it makes lives.
    pub place: Place,
    /// Whether it belongs to the recording in which it happened: no correction can undo it at run time.
    pub of_one_time: bool,
    /// Whether the column is a measurement of its own: whatever is left of it beside a model is then real, and
    /// not the rounding or the noise of another column that it was computed from.
    pub measured: bool,
    /// Whether it is a step, its one shape parameter the row from which on it is there: every row is then tried.
    pub begins_at_a_row: bool,
    /// Whether it can occur more than once in a recording (a second step, a second defect).
    pub repeatable: bool,
    /// Whether the shape follows from the amplitudes, so that it is not searched.
    pub shape_follows: bool,
    /// Which of its readings is a place on the angle at which something of one probe stands. It moves along the angle with
    /// the common mode.
    pub place_of_a_probe: Option<usize>,
    /// What it does with the common mode, which holds the noise of the probes.
    pub common_mode: CommonMode,
    /// Who says that there is such an effect.
    pub origin: Origin,
    /// What physics has this form, where it has no name.
    pub suggestions: Vec<String>,
    /// The experiments that tell it from others, each with what it does there.
    pub told_by: Vec<(Experiment, String)>,
}

/// An effect as the coefficients file knows it.
#[derive(Debug, Clone)]
pub struct Handed {
    /// The operator.
    pub operator: Operator,
    /// The operator's coefficients as a linear map of the amplitudes: one row per coefficient.
    pub map: Vec<Vec<f64>>,
}

/// All effects of the catalogue for a sensor, in the order in which ties are broken: the simpler explanation first.
pub fn catalogue(sensor: &Sensor) -> Arc<[Effect]> {
    let (pair, unit) = declared::of_sensor(sensor);
    catalogue_in(pair, unit)
}

/// The same for a position in `unit`, of a pair of probes or of a sensor that reports it; read once for each.
fn catalogue_in(pair: bool, unit: &str) -> Arc<[Effect]> {
    static READ: ReadOnce<(bool, String)> = ReadOnce::new();
    let made = || {
        declared::catalogued(physics::CATALOGUE, pair, unit)
            .unwrap_or_else(|error| unreachable!("the catalogue is read in every test: {error}"))
    };
    READ.get((pair, unit.to_string()), made)
}

/// The catalogue for a reader: the position is in `p`.
pub fn listed() -> Arc<[Effect]> {
    catalogue_in(true, "p")
}

/// dθ/dt by the difference to the row before in the same pass, as a controller forms it and `rate` of the coefficients
/// file is applied, in the recording's unit per second; the first row of a pass has that of the second.
pub fn velocity(rows: &Rows) -> Vec<f64> {
    let n = rows.len();
    let same = |a: usize, b: usize| b < n && rows.pass[a] == rows.pass[b];
    let between = |a: usize, b: usize| {
        let dt = rows.t_s[b] - rows.t_s[a];
        if dt > 0.0 { (rows.theta[b] - rows.theta[a]) / dt } else { 0.0 }
    };
    (0..n)
        .map(|i| match i {
            _ if i > 0 && same(i - 1, i) => between(i - 1, i),
            _ if same(i, i + 1) => between(i, i + 1),
            _ => 0.0,
        })
        .collect()
}

#[cfg(test)]
mod tests;
