//! What Python hands over for a recording: the path of a file, a table of Arrow's C interface, or a dict of columns.

use std::path::PathBuf;

use arrow_array::ArrayRef;
use arrow_schema::TimeUnit;
use fitter::message::Message;
use fitter::recording::{Mapping, Note, Reading};
use fitter::table::{Cells, IN_MEMORY};
use fitter::{Recording, text_safety};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use pyo3_arrow::input::{AnyArray, AnyRecordBatch};

use crate::arrow::{self, Taken};
use crate::error::refused;
use crate::python;

/// What was given.
pub enum Given {
    /// A file, which is read as the program reads it.
    File(PathBuf),
    /// Columns in memory.
    Table(Table),
}

/// Columns in memory.
pub struct Table {
    /// The name that stands in messages and provenance.
    pub name: String,
    /// Names and cells.
    pub columns: Vec<(String, Cells)>,
    /// Which of them hold timestamps.
    pub timestamps: Vec<String>,
}

impl Given {
    /// Understands what was given, under this `name` if one is given.
    pub fn of(object: &Bound<'_, PyAny>, name: Option<&str>) -> PyResult<Given> {
        if let Ok(path) = object.extract::<PathBuf>() {
            return Ok(Given::File(path));
        }
        let taken = match object.cast::<PyDict>() {
            Ok(dict) => dict.iter().map(|(name, values)| pair(&name, &values)).collect::<PyResult<_>>()?,
            Err(_) => of_frame(object)?,
        };
        let name = name.map_or_else(|| IN_MEMORY.to_string(), |name| text_safety::file_name(name.as_ref()));
        let mut table = Table { name, columns: Vec::new(), timestamps: Vec::new() };
        for (name, Taken { cells, timestamps }) in taken {
            if timestamps {
                table.timestamps.push(name.clone());
            }
            table.columns.push((name, cells));
        }
        Ok(Given::Table(table))
    }

    /// How it stands in a command.
    pub fn word(&self) -> String {
        match self {
            Given::File(path) => path.to_string_lossy().into_owned(),
            Given::Table(table) => table.name.clone(),
        }
    }

    /// The name of its file without the folder.
    pub fn file_name(&self) -> String {
        text_safety::file_name(self.word().as_ref())
    }

    /// What is noticed of columns that were converted.
    pub fn converted(&self) -> Vec<Note> {
        let Given::Table(Table { timestamps, .. }) = self else { return Vec::new() };
        timestamps.iter().cloned().map(|column| Note::Timestamps { column, from: None }).collect()
    }

    /// Reads a calibration.
    pub fn recording(self, reading: &Reading) -> Result<Recording, Message> {
        let converted = self.converted();
        let mut recording = match self {
            Given::File(path) => Recording::read_as(&path, reading, &mut |_| {})?,
            Given::Table(table) => Recording::of_columns(&table.name, table.columns, reading)?,
        };
        recording.notes.extend(converted);
        Ok(recording)
    }
}

/// Warns where points in time stand for seconds.
pub fn warn_of_times(py: Python<'_>, notes: &[Note]) -> PyResult<()> {
    let times = notes.iter().filter(|note| matches!(note, Note::Timestamps { .. }));
    python::warn(py, &times.map(ToString::to_string).collect::<Vec<_>>())
}

/// Columns under other names and in other units, as `x1_mm=Probe1:um` or as a dict of `x1_mm` and `Probe1:um`.
pub fn mappings(map: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Mapping>> {
    let Some(map) = map else { return Ok(Vec::new()) };
    let texts: Vec<String> = match map.cast::<PyDict>() {
        Ok(dict) => dict.iter().map(|(target, source)| format!("{target}={source}")).collect(),
        Err(_) => map.extract()?,
    };
    let parsed = texts.iter().map(|text| text.parse());
    parsed.collect::<Result<_, String>>().map_err(|wrong| refused(map.py(), &Message::of(wrong).by("map")))
}

/// The columns of a table; an index that pandas adds is none of its columns.
fn of_frame(object: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Taken)>> {
    let py = object.py();
    if !["__arrow_c_stream__", "__arrow_c_array__"].iter().any(|name| object.hasattr(*name).unwrap_or(false))
    {
        let found = object.get_type().name()?.to_string();
        let expected = "a path, a table (pandas, polars, pyarrow, DuckDB: anything with __arrow_c_stream__), or a dict of columns";
        return Err(refused(py, &Message::of("is no recording").found(found).expected(expected)));
    }
    let table = match object.extract::<AnyRecordBatch>() {
        Ok(table) => table.into_table()?,
        // Without pyarrow pandas knows its columns, and not the interface.
        Err(error) if error.is_instance_of::<PyImportError>(py) && object.hasattr("items")? => {
            let pairs = object.call_method0("items")?.try_iter()?;
            let one = |item: Bound<'_, PyAny>| pair(&item.get_item(0)?, &item.get_item(1)?);
            return pairs.map(|item| one(item?)).collect();
        }
        Err(error) => return Err(error),
    };
    let (batches, schema) = table.into_inner();
    let wanted = |name: &str| !name.starts_with("__index_level_");
    let fields = schema.fields().iter().enumerate().filter(|(_, field)| wanted(field.name()));
    fields
        .map(|(index, field)| {
            let pieces: Vec<ArrayRef> = batches.iter().map(|batch| batch.column(index).clone()).collect();
            let taken =
                arrow::take(&pieces, field.data_type()).map_err(pyo3_arrow::error::PyArrowError::from)?;
            Ok((field.name().clone(), taken))
        })
        .collect()
}

/// A column of a dict.
fn pair(name: &Bound<'_, PyAny>, values: &Bound<'_, PyAny>) -> PyResult<(String, Taken)> {
    let py = name.py();
    let Ok(text) = name.extract::<String>() else {
        let found = name.repr()?.to_string();
        return Err(refused(
            py,
            &Message::of("a column's name is no text").cell(found).mend("name the columns"),
        ));
    };
    if let Ok(array) = values.extract::<AnyArray>() {
        let (pieces, field) = array.into_chunked_array()?.into_inner();
        let taken = arrow::take(&pieces, field.data_type()).map_err(pyo3_arrow::error::PyArrowError::from)?;
        return Ok((text, taken));
    }
    let array = if values.hasattr("to_numpy")? { values.call_method0("to_numpy")? } else { values.clone() };
    let taken = if array.hasattr("dtype")? { of_numpy(&array)? } else { of_sequence(&text, &array)? };
    Ok((text, taken))
}

/// An array of numpy.
fn of_numpy(array: &Bound<'_, PyAny>) -> PyResult<Taken> {
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let [rows] = shape[..] else {
        return Ok(Cells::Nested {
            rows: shape.first().copied().unwrap_or(0),
            found: "an array of several dimensions",
        }
        .into());
    };
    let size: usize = dtype.getattr("itemsize")?.extract()?;
    let ticks = |unit: &str| -> PyResult<Vec<Option<i64>>> {
        let whole = array.call_method1("astype", (unit,))?.call_method1("astype", ("int64",))?;
        let values: Vec<i64> = plain::<i64>(&whole, "int64")?;
        // That is how numpy writes that there is no time.
        Ok(values.into_iter().map(|ticks| Some(ticks).filter(|ticks| *ticks != i64::MIN)).collect())
    };
    match kind.as_str() {
        "f" if size == 4 => {
            let meant = |value: f32| value.to_string().parse().unwrap_or_else(|_| f64::from(value));
            let values = plain::<f32>(array, "float32")?;
            Ok(Cells::Numbers(values.into_iter().map(meant).collect()).into())
        }
        "f" | "i" | "u" | "b" => Ok(Cells::Numbers(plain::<f64>(array, "float64")?.into()).into()),
        "M" => {
            let cells = arrow::since_first(&ticks("datetime64[ns]")?, TimeUnit::Nanosecond);
            Ok(Taken { cells, timestamps: true })
        }
        "m" => {
            let seconds = |ticks: Option<i64>| Some(ticks? as f64 / 1e9);
            Ok(arrow::of_optional(ticks("timedelta64[ns]")?.into_iter().map(seconds).collect()).into())
        }
        "O" | "U" => of_sequence("", &array.call_method0("tolist")?),
        _ => Ok(Cells::Texts(vec![Some(dtype.str()?.to_string()); rows]).into()),
    }
}

/// The values of an array, in this type of numpy.
fn plain<T: numpy::Element + Copy>(array: &Bound<'_, PyAny>, dtype: &str) -> PyResult<Vec<T>> {
    let contiguous = array.py().import("numpy")?.call_method1("ascontiguousarray", (array, dtype))?;
    Ok(contiguous.cast::<PyArray1<T>>()?.to_vec()?)
}

/// A list or another sequence: numbers, text, None; or times.
fn of_sequence(name: &str, values: &Bound<'_, PyAny>) -> PyResult<Taken> {
    let nested = |rows, found| Ok(Taken::from(Cells::Nested { rows, found }));
    if values.is_instance_of::<PyString>() || values.try_iter().is_err() {
        let found = values.repr()?.to_string();
        let message = Message::default()
            .column(name)
            .cell(found)
            .expected("a list or an array, one value for each row");
        return Err(refused(values.py(), &message));
    }
    let items: Vec<Bound<'_, PyAny>> = values.try_iter()?.collect::<PyResult<_>>()?;
    let first = items.iter().find(|item| !item.is_none());
    if let Some(first) = first
        && first.hasattr("tzinfo")?
        && first.hasattr("timestamp")?
    {
        return of_datetimes(first, &items);
    }
    let number = |item: &Bound<'_, PyAny>| match item.cast::<PyBool>() {
        Ok(truth) => Some(f64::from(u8::from(truth.is_true()))),
        Err(_) => item.extract::<f64>().ok(),
    };
    if items
        .iter()
        .any(|item| !item.is_none() && !item.is_instance_of::<PyString>() && number(item).is_none())
    {
        return nested(items.len(), "a list of other objects");
    }
    if items.iter().any(|item| item.is_instance_of::<PyString>()) {
        let text = |item: &Bound<'_, PyAny>| {
            if item.is_none() { Ok(None) } else { Ok(Some(item.str()?.to_string())) }
        };
        return Ok(Cells::Texts(items.iter().map(text).collect::<PyResult<_>>()?).into());
    }
    Ok(arrow::of_optional(items.iter().map(number).collect()).into())
}

/// Seconds since the first of these times.
fn of_datetimes(first: &Bound<'_, PyAny>, items: &[Bound<'_, PyAny>]) -> PyResult<Taken> {
    let since = |item: &Bound<'_, PyAny>| -> PyResult<Option<f64>> {
        if item.is_none() {
            return Ok(None);
        }
        item.sub(first)?.call_method0("total_seconds")?.extract().map(Some)
    };
    let cells = arrow::of_optional(items.iter().map(since).collect::<PyResult<_>>()?);
    Ok(Taken { cells, timestamps: true })
}
