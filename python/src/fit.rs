//! `fit` in Python.

use std::borrow::Cow;
use std::path::PathBuf;

use arcsmith::shared::{command_line, fit_summary};
use codegen::cli::terminal::called_with;
use fitter::faults::{self, Screened};
use fitter::message::Message;
use fitter::order::Splits;
use fitter::recording::{Purpose, Reading};
use pages::{Beside, Report, Text};
use fitter::{Fitted, Options, Solver};
use pyo3::prelude::*;
use serde_json::json;

use crate::coefficients::{Coefficients, mirror as nominal, write};
use crate::error::{detached, refused};
use crate::python;
use crate::table::{Given, mappings, warn_of_times};

/// A fit: the order that was chosen, the coefficients, and what they leave. `print` shows what the program prints.
#[pyclass(frozen, module = "arcsmith")]
pub struct Fit {
    /// The fit.
    pub fit: fitter::Fit,
    screened: Screened<'static>,
}

#[pymethods]
impl Fit {
    /// The coefficients, for `apply` and `generate`.
    #[getter]
    fn coefficients(&self) -> Coefficients {
        Coefficients(self.fit.coefficients.clone())
    }

    /// The order of the polynomial.
    #[getter]
    fn order(&self) -> usize {
        self.fit.coefficients.base.order
    }

    /// Number of harmonics of the turn; None of a sensor that does not turn round.
    #[getter]
    fn harmonics(&self) -> Option<usize> {
        let turn = self.fit.coefficients.turn.as_ref().filter(|turn| turn.whole);
        turn.map(|turn| turn.amplitudes.len())
    }

    /// Unit of the errors: arcsec, or that of a direct sensor.
    #[getter]
    fn unit(&self) -> &str {
        &self.fit.coefficients.units.statistics
    }

    /// Root mean square of the error before the correction, in `unit`.
    #[getter]
    fn before_rms(&self) -> Option<f64> {
        self.fit.coefficients.statistics.as_ref().map(|statistics| statistics.before.rms)
    }

    /// Root mean square of what the fit leaves, in `unit`.
    #[getter]
    fn after_rms(&self) -> Option<f64> {
        self.fit.coefficients.statistics.as_ref().map(|statistics| statistics.after.rms)
    }

    /// Sentences about the recording and the fit.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let fit = self.fit.notes.iter().map(ToString::to_string);
        fit.chain(self.screened.notes.iter().cloned()).collect()
    }

    /// What `arcsmith fit --json` prints, but for the file that it writes.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut value = fit_summary::json(&self.fit);
        value["bad_rows"] = json!(self.screened.bad_rows);
        value["findings"] = json!(self.screened.notes);
        python::from_json(py, &value.to_string())
    }

    /// The report: one self-contained page (HTML).
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let report = Report::of(&self.screened.recording, &self.fit, &[])?;
            let summary = &fit_summary::plain_text(&self.fit);
            let bad_rows = &self.screened.bad_rows;
            let text = Text { bad_rows, budget: None, summary, beside: &Beside::default() };
            Ok(report.page(&report.figures(), &text))
        })
    }

    /// The figures of the report (SVG), by title; a notebook shows them.
    fn plot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python::figures(py, &self.report(py)?)
    }

    /// Writes the coefficients; the file appears whole or not at all.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        write(py, &path, &self.fit.coefficients.to_sealed_json())
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        python::framed(py, &self.report(py)?)
    }

    fn __str__(&self) -> String {
        fit_summary::plain_text(&self.fit).trim_end().to_string()
    }

    fn __repr__(&self) -> String {
        let (before, after) = (self.before_rms().unwrap_or(f64::NAN), self.after_rms().unwrap_or(f64::NAN));
        let file = &self.fit.coefficients.recording.file;
        format!(
            "<arcsmith.Fit of {file}: order {}, rms {before:.3} to {after:.3} {}>",
            self.order(),
            self.unit()
        )
    }
}

/// Fits the angular error of a sensor, and chooses the order of the model by cross-validation.
///
/// `recording` is the path of a file, a table (pandas, polars, pyarrow, DuckDB: anything with `__arrow_c_stream__`), or a
/// dict of columns. Its columns: `t_s` (s), `pass`, `direction` (1 or -1), `x1_mm`, `x2_mm` (mm), `reference_arcsec`
/// (arcsec); of a sensor that reports the angle itself `measured` and `reference` in its unit. `map` takes columns under
/// other names and in other units: `{"x1_mm": "Probe1:um"}`. `mirror` is the path of mirror.toml, or a dict of its sections.
///
/// `order`, `harmonics`: used instead of being chosen. `splits`, `held_out_percent`, `seed`: of the cross-validation.
/// `solver`: "qr" or "trust-region". `average`: fit the averages over passes. `probe_distance_error`: in mm, measured
/// elsewhere. `name`: of the recording in messages and provenance.
///
/// Raises ArcsmithError.
#[pyfunction]
#[pyo3(signature = (
    recording, mirror, *, map=None, order=None, harmonics=None, splits=100, held_out_percent=30, seed=1, solver="qr",
    average=false, probe_distance_error=None, name=None
))]
#[allow(clippy::too_many_arguments)] // keywords of Python
pub fn fit(
    py: Python<'_>,
    recording: &Bound<'_, PyAny>,
    mirror: &Bound<'_, PyAny>,
    map: Option<&Bound<'_, PyAny>>,
    order: Option<usize>,
    harmonics: Option<usize>,
    splits: usize,
    held_out_percent: u8,
    seed: u64,
    solver: &str,
    average: bool,
    probe_distance_error: Option<f64>,
    name: Option<&str>,
) -> PyResult<Fit> {
    let (mirror, mirror_word) = nominal(mirror)?;
    let given = Given::of(recording, name)?;
    let mappings = mappings(map)?;
    let mut words = vec!["arcsmith".to_string(), "fit".into(), given.word(), "--mirror".into(), mirror_word];
    let mut option = |name: &str, value: String| words.extend([format!("--{name}"), value]);
    mappings.iter().for_each(|mapping| option("map", mapping.to_string()));
    order.iter().for_each(|order| option("order", order.to_string()));
    harmonics.iter().for_each(|count| option("harmonics", count.to_string()));
    [("splits", splits as u64, 100), ("held-out-percent", held_out_percent.into(), 30), ("seed", seed, 1)]
        .into_iter()
        .filter(|(_, value, usual)| value != usual)
        .for_each(|(name, value, _)| option(name, value.to_string()));
    (solver != "qr").then(|| option("solver", solver.to_string()));
    probe_distance_error.iter().for_each(|error| option("probe-distance-error", format!("{error:?}")));
    words.extend(average.then(|| "--average".to_string()));
    let options = Options {
        order,
        harmonics,
        splits: Splits { count: splits, held_out_share: f64::from(held_out_percent) / 100.0, seed },
        solver: solver_of(solver).map_err(|message| refused(py, &message))?,
        fitted: if average { Fitted::Averages } else { Fitted::Rows },
        probe_distance_error_mm: probe_distance_error,
        command: called_with(words.into_iter().map(Into::into).collect(), command_line),
        ..Options::default()
    };
    let fit = detached(py, || {
        let reading = Reading { purpose: Purpose::Fit, mappings: &mappings, sensor: Some(&mirror.sensor) };
        let recording = given.recording(&reading)?;
        let screened = faults::screen(Cow::Owned(recording), &mirror.sensor)?;
        let fit = fitter::fit(&screened.recording, &mirror, &options)?;
        Ok(Fit { fit, screened })
    })?;
    warn_of_times(py, &fit.screened.recording.notes)?;
    Ok(fit)
}

fn solver_of(name: &str) -> Result<Solver, Message> {
    match name {
        "qr" => Ok(Solver::Qr),
        "trust-region" => Ok(Solver::TrustRegion),
        other => Err(Message::of("there is no such solver").cell(other).expected("`qr` or `trust-region`")),
    }
}
