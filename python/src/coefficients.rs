//! Coefficients in Python, and the files that stand beside a recording: a path, or what the file holds.

use std::path::{Path, PathBuf};

use codegen::generate::sha256;
use fitter::coefficients::{self, Coefficients as File};
use fitter::message::Message;
use fitter::output::write_whole;
use fitter::plant::PlantFile;
use fitter::{Mirror, text_safety};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::diagnose::Diagnosis;
use crate::error::{detached, refused};
use crate::fit::Fit;
use crate::python;

/// The model of a sensor's error: what `apply` and `generate` take. `write` makes the file `coefficients.json`.
#[pyclass(frozen, module = "arcsmith")]
pub struct Coefficients(pub File);

#[pymethods]
impl Coefficients {
    /// Order of the base polynomial.
    #[getter]
    fn order(&self) -> usize {
        self.0.base.order
    }

    /// What the file holds: see the page "File formats".
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python::from_json(py, &self.0.to_sealed_json())
    }

    /// The text of the file, as the program writes it.
    fn to_json(&self) -> String {
        self.0.to_sealed_json()
    }

    /// Writes the file; it appears whole or not at all.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        write(py, &path, &self.0.to_sealed_json())
    }

    fn __repr__(&self) -> String {
        let File { base, recording, terms, .. } = &self.0;
        format!("<arcsmith.Coefficients of {}: order {}, {} terms>", recording.file, base.order, terms.len())
    }
}

/// Writes a text whole or not at all.
pub fn write(py: Python<'_>, path: &Path, text: &str) -> PyResult<()> {
    detached(py, || Ok(write_whole(path, |file| file.write_all(text.as_bytes()))?))
}

/// Coefficients as they were given, the SHA-256 of their file, and how they stand in a command.
pub struct Source {
    /// The coefficients.
    pub file: File,
    /// The hash of their file, or of that which would be written.
    pub sha256: String,
    /// The path that was given, or the usual name.
    pub word: String,
}

impl Source {
    /// Understands a path, a result of this module, or what a coefficients file holds.
    pub fn of(object: &Bound<'_, PyAny>) -> PyResult<Source> {
        let py = object.py();
        let held = |file: &File| Source {
            file: file.clone(),
            sha256: sha256(file.to_sealed_json()),
            word: "coefficients.json".into(),
        };
        if let Ok(coefficients) = object.cast::<Coefficients>() {
            return Ok(held(&coefficients.get().0));
        }
        if let Ok(fit) = object.cast::<Fit>() {
            return Ok(held(&fit.get().fit.coefficients));
        }
        if let Ok(diagnosis) = object.cast::<Diagnosis>() {
            return match diagnosis.get().file() {
                Some(file) => Ok(held(file)),
                None => {
                    let what = Message::of("the diagnosis handed on no coefficients");
                    Err(refused(py, &what.mend("see its `to_dict()[\"withheld\"]`, or give those of a fit")))
                }
            };
        }
        if object.is_instance_of::<PyDict>() {
            let parsed = coefficients::parse("coefficients.json", &python::to_json(object)?);
            return parsed.map(|file| held(&file)).map_err(|error| refused(py, &error.into()));
        }
        let path: PathBuf = object.extract()?;
        detached(py, || {
            let (file, text) = coefficients::read_with_text(&path)?;
            Ok(Source { file, sha256: sha256(&text), word: path.to_string_lossy().into_owned() })
        })
    }
}

/// The nominal mirror, and how it stands in a command.
pub fn mirror(object: &Bound<'_, PyAny>) -> PyResult<(Mirror, String)> {
    toml(object, "mirror.toml", Mirror::read, Mirror::parse)
}

/// The nominal plant, and its file.
pub fn plant(object: &Bound<'_, PyAny>) -> PyResult<(PlantFile, String)> {
    toml(object, "plant.toml", PlantFile::read, PlantFile::parse)
}

/// What a TOML file holds: of a path, or of a dict of its sections, which then has the usual name.
fn toml<T: Send, E: Into<Message>>(
    object: &Bound<'_, PyAny>,
    usual: &str,
    read: impl FnOnce(&Path) -> Result<T, E> + Send,
    parse: impl FnOnce(&str, &str) -> Result<T, E> + Send,
) -> PyResult<(T, String)> {
    let py = object.py();
    if !object.is_instance_of::<PyDict>() {
        let path: PathBuf = object.extract()?;
        let word = path.to_string_lossy().into_owned();
        return detached(py, || read(&path).map_err(E::into)).map(|file| (file, word));
    }
    let json = python::to_json(object)?;
    detached(py, || {
        let value: serde_json::Value = serde_json::from_str(&json)?;
        let unstated = |_| Message::of("holds None, which says nothing").at(usual).mend("leave the key out");
        let text = toml::to_string(&value).map_err(unstated)?;
        parse(usual, &text).map_err(E::into)
    })
    .map(|file| (file, usual.to_string()))
}

/// A path among others, for a message.
pub fn shown(word: &str) -> String {
    text_safety::path(word.as_ref())
}
