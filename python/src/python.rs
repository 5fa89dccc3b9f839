//! What Python's own library does for this module.

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// JSON as Python's objects.
pub fn from_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// Python's objects as JSON.
pub fn to_json(object: &Bound<'_, PyAny>) -> PyResult<String> {
    object.py().import("json")?.call_method1("dumps", (object,))?.extract()
}

/// Raises a warning at the line of the caller, for each of these.
pub fn warn(py: Python<'_>, texts: &[String]) -> PyResult<()> {
    let warnings = py.import("warnings")?;
    for text in texts {
        warnings.call_method1("warn", (text,))?;
    }
    Ok(())
}

/// The figures of a page, as Python shows them.
pub fn figures<'py>(py: Python<'py>, page: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("arcsmith._figures")?.getattr("Figures")?.call_method1("of_page", (page,))
}

/// A page inside a notebook's.
pub fn framed(py: Python<'_>, page: &str) -> PyResult<String> {
    py.import("arcsmith._figures")?.call_method1("framed", (page,))?.extract()
}

/// A table of named columns as pairs of a dict.
pub fn dict<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (String, Vec<f64>)>,
) -> PyResult<Bound<'py, PyDict>> {
    columns.into_iter().collect::<Vec<_>>().into_py_dict(py)
}
