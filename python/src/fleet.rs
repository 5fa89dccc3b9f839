//! `fleet.diagnose_batch` in Python: the unit of work of a fleet, Arrow in and Arrow out.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use arcsmith::shared::fleet_answer::{Answer, Unit};
use arcsmith::shared::fleet_choice::Choice;
use arcsmith::shared::fleet_table::{self, Cells as Written, Column};
use arrow_array::builder::{Float64Builder, ListBuilder, StringBuilder};
use arrow_array::{ArrayRef, Float64Array, StringArray, StructArray};
use arrow_schema::{DataType, Field, Fields};
use fitter::message::Message;
use fitter::table::Cells;
use fitter::{Recording, text_safety};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use pyo3_arrow::error::PyArrowResult;
use pyo3_arrow::ffi::{ArrayIterator, to_stream_pycapsule};

use crate::error::{detached, refused};
use crate::table::{Given, mappings};

/// Rows of a fleet's tables. pandas, polars, pyarrow and DuckDB take it as it is: `pyarrow.table(rows)`.
#[pyclass(frozen, module = "arcsmith.fleet")]
pub struct Rows(Vec<Column>);

#[pymethods]
impl Rows {
    /// The names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.0.iter().map(|(name, _)| name.to_string()).collect()
    }

    fn __len__(&self) -> usize {
        self.0.first().map_or(0, |(_, cells)| match cells {
            Written::Text(cells) => cells.len(),
            Written::Number(cells) => cells.len(),
            Written::Texts(cells) => cells.len(),
            Written::Numbers(cells) => cells.len(),
        })
    }

    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        let (fields, arrays): (Vec<Field>, Vec<ArrayRef>) =
            self.0.iter().map(|(name, cells)| of_arrow(name, cells)).unzip();
        let fields = Fields::from(fields);
        let batch = StructArray::try_new(fields.clone(), arrays, None)?;
        let field = Arc::new(Field::new_struct("", fields, false));
        let batches = std::iter::once(Ok(Arc::new(batch) as ArrayRef));
        to_stream_pycapsule(py, Box::new(ArrayIterator::new(batches, field)), requested_schema)
    }
}

/// A column in Arrow, of the same type as in the files of `arcsmith fleet`.
fn of_arrow(name: &str, cells: &Written) -> (Field, ArrayRef) {
    let element = |kind| Arc::new(Field::new("element", kind, false));
    match cells {
        Written::Text(cells) => {
            let array = StringArray::from(cells.clone());
            (Field::new(name, DataType::Utf8, true), Arc::new(array))
        }
        Written::Number(cells) => {
            (Field::new(name, DataType::Float64, true), Arc::new(Float64Array::from(cells.clone())))
        }
        Written::Texts(cells) => {
            let field = element(DataType::Utf8);
            let mut lists = ListBuilder::new(StringBuilder::new()).with_field(Arc::clone(&field));
            cells.iter().for_each(|list| lists.append_value(list.iter().map(Some)));
            (Field::new(name, DataType::List(field), false), Arc::new(lists.finish()))
        }
        Written::Numbers(cells) => {
            let field = element(DataType::Float64);
            let mut lists = ListBuilder::new(Float64Builder::new()).with_field(Arc::clone(&field));
            cells.iter().for_each(|list| lists.append_value(list.iter().copied().map(Some)));
            (Field::new(name, DataType::List(field), false), Arc::new(lists.finish()))
        }
    }
}

/// Diagnoses every unit of a table: the rows of one table of `arcsmith fleet`, "units" or "parameters", units in the order of
/// their first rows. A unit that fails is a row with its `error`. A pure function on one core, for an engine to run on groups
/// of units.
///
/// `batch` is anything that `diagnose` takes as a table, with a column `unit` that names the unit of a row; `lot` and `time` are
/// further columns that say something of a unit. `mirror` and `effects` are paths. The other options are those of `diagnose`.
///
/// Raises ArcsmithError.
#[pyfunction]
#[pyo3(signature = (
    batch, *, unit, mirror, lot=None, time=None, table="units", map=None, effects=None, without=None, harmonics=None,
    order=None, turn_harmonics=None
))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn diagnose_batch(
    py: Python<'_>,
    batch: &Bound<'_, PyAny>,
    unit: String,
    mirror: PathBuf,
    lot: Option<String>,
    time: Option<String>,
    table: &str,
    map: Option<&Bound<'_, PyAny>>,
    effects: Option<PathBuf>,
    without: Option<Vec<String>>,
    harmonics: Option<usize>,
    order: Option<usize>,
    turn_harmonics: Option<usize>,
) -> PyResult<Rows> {
    let of_units = match table {
        "units" => true,
        "parameters" => false,
        other => {
            let message = Message::of("`table`").found(other).expected("\"units\" or \"parameters\"");
            return Err(refused(py, &message));
        }
    };
    let Given::Table(given) = Given::of(batch, None)? else {
        let message =
            Message::of("a batch is a table").mend("read the file before: a folder is for `arcsmith fleet`");
        return Err(refused(py, &message));
    };
    let choice = Choice {
        mirror,
        effects,
        mappings: mappings(map)?,
        without: without.unwrap_or_default(),
        harmonics,
        order,
        turn_harmonics,
        columns: [Some(unit), lot, time],
    };
    detached(py, || {
        let asked = choice.asked()?;
        let answers: Vec<Answer> = (split(given.columns, &choice.columns)?.into_iter())
            .map(|(unit, columns)| {
                let name = format!("unit {}, table", text_safety::shown(&unit.name));
                asked.answer(unit, Recording::of_columns(&name, columns, &asked.reading()))
            })
            .collect();
        Ok(Rows(match of_units {
            true => fleet_table::units(&answers, &choice.hashed()?),
            false => fleet_table::parameters(&answers),
        }))
    })
}

type Columns = Vec<(String, Cells)>;

/// The columns of every unit, in the order of its first row.
fn split(columns: Columns, of_unit: &[Option<String>; 3]) -> Result<Vec<(Unit, Columns)>, Message> {
    let [unit, lot, time] = of_unit.each_ref().map(|name| {
        let name = name.as_ref()?;
        Some((name, columns.iter().find(|(other, _)| other == name).map(|(_, cells)| cells)))
    });
    let mut missing = [unit, lot, time].into_iter().flatten().filter(|(_, cells)| cells.is_none());
    if let Some((name, _)) = missing.next() {
        let found: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        return Err(Message::of(format!("there is no column `{name}`"))
            .expected(format!("one of {}", found.join(", "))));
    }
    let said = |of: Option<(&String, Option<&Cells>)>, row: usize| text(of?.1?, row);
    let rows = columns.first().map_or(0, |(_, cells)| length(cells));
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut units: Vec<(Unit, Vec<usize>)> = Vec::new();
    for row in 0..rows {
        let Some(name) = said(unit, row).filter(|name| !name.is_empty()) else {
            let column = unit.map_or("", |(name, _)| name);
            return Err(Message::of("names no unit")
                .line(row + 1)
                .column(column)
                .expected("a name in every row"));
        };
        let place = *places.entry(name.clone()).or_insert(units.len());
        if place == units.len() {
            let time = said(time, row).and_then(|text| text.parse().ok());
            units.push((Unit { name, file: "table".into(), lot: said(lot, row), time }, Vec::new()));
        }
        units[place].1.push(row);
    }
    let own: Vec<&(String, Cells)> =
        columns.iter().filter(|(name, _)| !of_unit.iter().flatten().any(|other| other == name)).collect();
    let picked = |(unit, rows): (Unit, Vec<usize>)| {
        (unit, own.iter().map(|(name, cells)| (name.clone(), pick(cells, &rows))).collect())
    };
    Ok(units.into_iter().map(picked).collect())
}

fn length(cells: &Cells) -> usize {
    match cells {
        Cells::Numbers(values) => values.len(),
        Cells::Nullable(values) => values.len(),
        Cells::Texts(values) => values.len(),
        Cells::Nested { rows, .. } => *rows,
    }
}

fn text(cells: &Cells, row: usize) -> Option<String> {
    match cells {
        Cells::Numbers(values) => {
            Some(values[row]).filter(|value| !value.is_nan()).map(|value| value.to_string())
        }
        Cells::Nullable(values) => values[row].map(|value| value.to_string()),
        Cells::Texts(values) => values[row].clone(),
        Cells::Nested { .. } => None,
    }
}

fn pick(cells: &Cells, rows: &[usize]) -> Cells {
    match cells {
        Cells::Numbers(values) => Cells::Numbers(rows.iter().map(|row| values[*row]).collect()),
        Cells::Nullable(values) => Cells::Nullable(rows.iter().map(|row| values[*row]).collect()),
        Cells::Texts(values) => Cells::Texts(rows.iter().map(|row| values[*row].clone()).collect()),
        Cells::Nested { found, .. } => Cells::Nested { rows: rows.len(), found },
    }
}
