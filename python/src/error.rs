//! What is refused, with the program's own message.

use codegen::cli::terminal::with_options;
use fitter::message::Message;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::python;

pyo3::create_exception!(
    arcsmith,
    ArcsmithError,
    PyValueError,
    "What was given is refused: one message, that of the program.\n\n\
     `parts` holds it in parts, as far as there are any: `file`, `line`, `column`, `found`, `expected`, `mend`. An option \
     that a message names is the keyword of that name: `--map` is `map`."
);

/// The exception of a message.
pub fn refused(py: Python<'_>, message: &Message) -> PyErr {
    let error = ArcsmithError::new_err(with_options(message));
    let parts = serde_json::to_string(message).unwrap_or_default();
    let set = python::from_json(py, &parts).and_then(|parts| error.value(py).setattr("parts", parts));
    match set {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// Works without holding Python up, and raises what is refused.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, Message> + Send) -> PyResult<T> {
    py.detach(work).map_err(|message| refused(py, &message))
}
