//! Columns that Python takes: by Arrow's C interface without a copy, or as a dict.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, StructArray};
use arrow_schema::{DataType, Field, Fields};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};
use pyo3_arrow::error::PyArrowResult;
use pyo3_arrow::ffi::{ArrayIterator, to_stream_pycapsule};

use crate::coefficients::write;
use crate::python;

/// Columns of numbers, row for row of what was given. pandas, polars, pyarrow and DuckDB take it as it is:
/// `polars.DataFrame(columns)`.
#[pyclass(frozen, module = "arcsmith")]
pub struct Columns {
    names: Vec<String>,
    values: Vec<Float64Array>,
    notes: Vec<String>,
    /// JSON of what is said beside them.
    said: String,
}

impl Columns {
    /// Columns by name, with notes and the summary of the program (JSON).
    pub fn new(columns: Vec<(String, Vec<f64>)>, notes: Vec<String>, said: String) -> Columns {
        let (names, values) =
            columns.into_iter().map(|(name, values)| (name, Float64Array::from(values))).unzip();
        Columns { names, values, notes, said }
    }

    /// Sentences that are warnings.
    pub fn warnings(&self) -> &[String] {
        &self.notes
    }

    fn rows(&self) -> usize {
        self.values.first().map_or(0, |column| column.len())
    }
}

#[pymethods]
impl Columns {
    /// The names of the columns; each ends in its unit.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.names.clone()
    }

    /// Sentences that the program prints as warnings.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// What the program prints with `--json`, but for the file that it writes.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python::from_json(py, &self.said)
    }

    /// The columns as lists.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        python::dict(
            py,
            self.names.iter().cloned().zip(self.values.iter().map(|column| column.values().to_vec())),
        )
    }

    /// A line for each column over the first one (SVG); a notebook shows them.
    fn plot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("arcsmith._figures")?.getattr("Figures")?.call_method1("of_columns", (self.to_dict(py)?,))
    }

    /// Writes the columns as CSV, every number with the digits that give it back exactly.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let row = |row: usize| {
            let cells: Vec<String> = self.values.iter().map(|column| column.value(row).to_string()).collect();
            cells.join(",") + "\n"
        };
        let text: String = (0..self.rows()).map(row).collect();
        write(py, &path, &format!("{}\n{text}", self.names.join(",")))
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        py.import("arcsmith._figures")?.call_method1("table", (self.to_dict(py)?,))?.extract()
    }

    fn __getitem__(&self, name: &str) -> PyResult<Vec<f64>> {
        let at = self.names.iter().position(|other| other == name);
        at.map(|at| self.values[at].values().to_vec()).ok_or_else(|| PyKeyError::new_err(name.to_string()))
    }

    fn __len__(&self) -> usize {
        self.rows()
    }

    fn __repr__(&self) -> String {
        format!("<arcsmith.Columns {}: {} rows>", self.names.join(", "), self.rows())
    }

    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyArrowResult<Bound<'py, PyCapsule>> {
        let fields: Fields =
            self.names.iter().map(|name| Field::new(name, DataType::Float64, false)).collect();
        let arrays = self.values.iter().map(|column| Arc::new(column.clone()) as ArrayRef).collect();
        let batch = StructArray::try_new(fields.clone(), arrays, None)?;
        let field = Arc::new(Field::new_struct("", fields, false));
        let batches = std::iter::once(Ok(Arc::new(batch) as ArrayRef));
        to_stream_pycapsule(py, Box::new(ArrayIterator::new(batches, field)), requested_schema)
    }
}
