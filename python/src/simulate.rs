//! `simulate` in Python.

use fitter::message::Message;
use fitter::recording::Note;
use fitter::table::Values;
use pyo3::prelude::*;
use serde_json::json;
use twin::dynamic::{Begin, Series, simulate as run};

use crate::coefficients::{plant as nominal, shown};
use crate::columns::Columns;
use crate::error::{detached, refused};
use crate::table::{Given, warn_of_times};

/// Runs a plant, with all that was found in it, on the drive of a recording.
///
/// `drive` is the path of a file, a table or a dict of columns, as for `fit`: `t_s` (s), `drive` (`drive_1`, `drive_2`, …)
/// in drive units, optionally `position`, `run`, `period`. `plant` is the path of plant.toml, or a dict of its sections.
/// `begin`: "recorded", as the first rows of the recorded position say (the default where there is one), or "rest".
///
/// Returns the columns `t_s` (s), `run` and `period` as given, and `position` (`position_1`, …) in position units.
///
/// Raises ArcsmithError.
#[pyfunction]
#[pyo3(signature = (drive, plant, *, begin=None, name=None))]
pub fn simulate(
    py: Python<'_>,
    drive: &Bound<'_, PyAny>,
    plant: &Bound<'_, PyAny>,
    begin: Option<&str>,
    name: Option<&str>,
) -> PyResult<Columns> {
    let (plant, word) = nominal(plant)?;
    let given = Given::of(drive, name)?;
    let begin = begin.map(beginning).transpose().map_err(|message| refused(py, &message))?;
    let mut notes = given.converted();
    let (simulated, notes) = detached(py, || {
        let driven = !plant.equations.as_ref().is_some_and(|equations| equations.inputs.0.is_empty());
        let recording = match given {
            Given::File(path) if driven => Series::read(&path)?,
            Given::File(path) => Series::read_undriven(&path)?,
            Given::Table(table) => Series::of_columns(&table.name, table.columns, driven)?,
        };
        let known = recording.positions.len() == 1 && plant.state_space.is_none();
        let begin = begin.unwrap_or(if known { Begin::Recorded } else { Begin::Rest });
        let simulated = run(&shown(&word), &plant, &recording, begin)?;
        notes.extend(recording.started.map(Note::since));
        Ok((simulated, notes))
    })?;
    warn_of_times(py, &notes)?;
    let said = json!({"rows": simulated.t_s.len()}).to_string();
    Ok(Columns::new(columns(simulated), notes.iter().map(ToString::to_string).collect(), said))
}

fn beginning(name: &str) -> Result<Begin, Message> {
    match name {
        "recorded" => Ok(Begin::Recorded),
        "rest" => Ok(Begin::Rest),
        other => Err(Message::of("there is no such beginning").cell(other).expected("`recorded` or `rest`")),
    }
}

fn columns(series: Series) -> Vec<(String, Vec<f64>)> {
    let whole = |numbers: Vec<i64>| numbers.into_iter().map(|number| number as f64).collect();
    let mut columns = vec![("t_s".to_string(), series.t_s.into_vec())];
    columns.extend(series.run.map(|numbers| ("run".into(), whole(numbers))));
    columns.extend(series.period.map(|numbers| ("period".into(), whole(numbers))));
    columns.extend(numbered("position", series.positions.into_iter().map(Values::into_vec)));
    columns
}

/// Columns of one kind: `position` alone, or `position_1`, `position_2`, ….
pub fn numbered(
    stem: &str,
    columns: impl ExactSizeIterator<Item = Vec<f64>>,
) -> impl Iterator<Item = (String, Vec<f64>)> {
    let (stem, several) = (stem.to_string(), columns.len() > 1);
    let name = move |k: usize| if several { format!("{stem}_{}", k + 1) } else { stem.clone() };
    columns.enumerate().map(move |(k, values)| (name(k), values))
}
