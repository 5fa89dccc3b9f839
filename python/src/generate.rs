//! `generate` in Python: the program's options are keywords.

use std::path::PathBuf;

use clap::Parser;
use codegen::certificate::RangeEntry;
use codegen::cli::Arguments;
use codegen::cli::terminal::called_with;
use codegen::files;
use codegen::text::rounded_up;
use fitter::figures::plain;
use fitter::message::Message;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyList, PyTuple};
use serde_json::json;

use crate::coefficients::Source;
use crate::error::{detached, refused};
use crate::python;

/// Routines with their proven bounds: nothing is written before `write`.
#[pyclass(frozen, module = "arcsmith")]
pub struct Generated(codegen::generate::Generated);

/// The options of `arcsmith generate`.
#[derive(Parser)]
struct Words {
    #[command(flatten)]
    arguments: Arguments,
}

#[pymethods]
impl Generated {
    /// The contents of the files, by their path in the folder.
    #[getter]
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let files = PyDict::new(py);
        for (path, text) in &self.0.files {
            files.set_item(path.to_string_lossy(), text)?;
        }
        Ok(files)
    }

    /// The certificate: input, output, range, bound and its parts of every routine.
    #[getter]
    fn certificate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python::from_json(py, &json!(self.0.certificate).to_string())
    }

    /// Sentences that the program prints as warnings.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let left_out = self.0.unreachable.iter().map(|missing| format!("left out: {missing}"));
        left_out.chain(self.0.certificate.reservation.clone()).collect()
    }

    /// What `arcsmith generate --json` prints, but for the folder that it writes.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let value = json!({
            "reservation": self.0.certificate.reservation,
            "routines": self.0.certificate.routines,
            "files": self.0.files.keys().collect::<Vec<_>>(),
        });
        python::from_json(py, &value.to_string())
    }

    /// Writes the files into a folder, all of them or none, and returns how many changed.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<usize> {
        detached(py, || Ok(files::write(&folder, &self.0.files)?))
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let rows: Vec<[String; 4]> = self.routines().collect();
        py.import("arcsmith._figures")?.call_method1("routines", (rows,))?.extract()
    }

    fn __str__(&self) -> String {
        let line = |[name, language, range, bound]: [String; 4]| {
            format!("{name} ({language}), {range}: proven within {bound}")
        };
        self.routines().map(line).collect::<Vec<_>>().join("\n")
    }

    fn __repr__(&self) -> String {
        format!("<arcsmith.Generated {}: {} files>", self.0.name, self.0.files.len())
    }
}

impl Generated {
    /// Name, language, range and bound of every routine.
    fn routines(&self) -> impl Iterator<Item = [String; 4]> + '_ {
        self.0.certificate.routines.iter().map(|entry| {
            let RangeEntry { variable, unit, from, to, .. } = &entry.range;
            let range = format!("{variable} from {} to {} {unit}", plain(*from), plain(*to));
            let bound = format!("{} {}", rounded_up(entry.bound), entry.unit);
            [entry.routine.clone(), entry.language.clone(), range, bound]
        })
    }
}

/// Generates the correction for firmware, in Rust and C, with a proven bound.
///
/// `coefficients` is a fit, a diagnosis, coefficients, or the path of their file. The keywords are the options of `arcsmith
/// generate`, with `_` for `-`: `format="q31"`, `input="x1x2-counts"`, `bits=16`, `gain=1.5259e-5` (mm per count),
/// `output="nano"`, `bound_arcsec=0.01`, `target="cortex-m4f"`, `fma=True` (floats with fused multiply-adds),
/// `accept_unexplained=True`; a list gives an option several values.
///
/// Raises ArcsmithError; warns of what the program warns of.
#[pyfunction]
#[pyo3(signature = (coefficients, **options))]
pub fn generate(
    py: Python<'_>,
    coefficients: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Generated> {
    let source = Source::of(coefficients)?;
    let mut words = vec!["generate".to_string(), "--coefficients".into(), source.word.clone()];
    for (name, value) in options.into_iter().flat_map(|options| options.iter()) {
        option(&mut words, &name.extract::<String>()?, &value)?;
    }
    let generated = detached(py, || {
        let parsed = Words::try_parse_from(&words)
            .map_err(|error| Message::of(first_paragraph(&error.to_string())))?;
        let words = std::iter::once("arcsmith").chain(words.iter().map(String::as_str));
        let designed = || parsed.arguments.of(&source.file, &source.sha256);
        Ok(Generated(called_with(words.map(Into::into).collect(), designed)?.0))
    })?;
    python::warn(py, &generated.notes())?;
    Ok(generated)
}

/// What the program does with folders and many devices is no keyword.
const NO_KEYWORDS: [&str; 11] = [
    "coefficients",
    "recording",
    "mirror",
    "demo",
    "devices",
    "margin",
    "page_address",
    "pages_for",
    "out",
    "check",
    "json",
];

/// Adds an option with its value, as it would be typed.
fn option(words: &mut Vec<String>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    if NO_KEYWORDS.contains(&name) {
        let message = Message::of("is no keyword of `generate`").about(name);
        return Err(refused(value.py(), &message.mend("use the program for it: arcsmith generate")));
    }
    let dashed = format!("--{}", name.replace('_', "-"));
    if let Ok(wanted) = value.cast::<PyBool>() {
        words.extend(wanted.is_true().then_some(dashed));
    } else if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        value.try_iter()?.try_for_each(|value| option(words, name, &value?))?;
    } else if let Ok(number) = value.cast::<PyFloat>() {
        words.extend([dashed, format!("{:?}", number.extract::<f64>()?)]);
    } else if !value.is_none() {
        words.extend([dashed, value.str()?.to_string()]);
    }
    Ok(())
}

/// What is wrong, without the usage that is shown beside.
fn first_paragraph(text: &str) -> &str {
    let text = text.trim_start_matches("error: ");
    text.split_once("\n\n").map_or(text, |(first, _)| first).trim_end()
}
