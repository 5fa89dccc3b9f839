//! Arcsmith in Python: the libraries on tables in memory, and the program.
//!
//! Everything is computed by the libraries that the program calls, so that the same numbers come out to the bit. What is
//! said here of Python is documentation for its users; types stand in `package/arcsmith/__init__.pyi`.

mod apply;
mod arrow;
mod coefficients;
mod columns;
mod diagnose;
mod error;
mod fit;
mod fleet;
mod generate;
mod python;
mod simulate;
mod table;

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

/// Runs the program with these words, its own path first, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    let code = py.detach(|| arcsmith::run(words));
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(u8::MAX)
}

/// The compiled part of `arcsmith`.
#[pymodule]
fn _arcsmith(module: &Bound<'_, PyModule>) -> PyResult<()> {
    parquet_tables::register();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("ArcsmithError", module.py().get_type::<error::ArcsmithError>())?;
    module.add_class::<coefficients::Coefficients>()?;
    module.add_class::<columns::Columns>()?;
    module.add_class::<diagnose::Diagnosis>()?;
    module.add_class::<fit::Fit>()?;
    module.add_class::<fleet::Rows>()?;
    module.add_class::<generate::Generated>()?;
    module.add_function(wrap_pyfunction!(apply::apply, module)?)?;
    module.add_function(wrap_pyfunction!(diagnose::diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    module.add_function(wrap_pyfunction!(fleet::diagnose_batch, module)?)?;
    module.add_function(wrap_pyfunction!(generate::generate, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}
