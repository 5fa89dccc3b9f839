//! `apply` in Python.

use fitter::message::Message;
use fitter::recording::{Purpose, Reading};
use fitter::{acceptance, apply as libraries};
use pyo3::prelude::*;
use serde_json::json;

use crate::coefficients::{Source, shown};
use crate::columns::Columns;
use crate::error::detached;
use crate::python;
use crate::table::{Given, mappings, warn_of_times};

/// Corrects every row of a recording, which needs no reference.
///
/// `recording`, `map` and `name` are as for `fit`. `coefficients` is a fit, a diagnosis, coefficients, or the path of their
/// file. `strict` refuses a recording that lacks a column which the coefficients depend on, instead of leaving the effect
/// out.
///
/// Returns the columns `t_s` (s), the corrected reading (`angle_arcsec` in arcsec, of a direct sensor `corrected_…` in its
/// unit), and `extrapolated` (1 of a row outside the valid range or with a cell that cannot be a reading, else 0).
///
/// Raises ArcsmithError; warns of what the program warns of.
#[pyfunction]
#[pyo3(signature = (recording, coefficients, *, map=None, strict=false, name=None))]
pub fn apply(
    py: Python<'_>,
    recording: &Bound<'_, PyAny>,
    coefficients: &Bound<'_, PyAny>,
    map: Option<&Bound<'_, PyAny>>,
    strict: bool,
    name: Option<&str>,
) -> PyResult<Columns> {
    let Source { file, word, .. } = Source::of(coefficients)?;
    let (given, mappings) = (Given::of(recording, name)?, mappings(map)?);
    let (columns, read) = detached(py, || {
        let usable = acceptance::to_apply(&file);
        usable.map_err(|refusal| Message::of(refusal).at(&shown(&word)).mend("fit again"))?;
        let reading = Reading { purpose: Purpose::Apply, mappings: &mappings, sensor: Some(&file.sensor) };
        let recording = given.recording(&reading)?;
        if strict {
            libraries::check_columns(&recording, &file)?;
        }
        let applied = libraries::apply_screened(&recording, &file)?;
        let notes: Vec<String> = applied.notes.iter().map(ToString::to_string).collect();
        let said = json!({
            "recording": recording.file,
            "rows": recording.rows(),
            "extrapolated": applied.extrapolated.iter().filter(|marked| **marked).count(),
            "bad_rows": applied.bad_rows,
            "read": recording.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "warnings": notes,
        });
        let scale = file.sensor.per_internal();
        let columns = vec![
            ("t_s".to_string(), recording.time_s.to_vec()),
            (
                libraries::column_name(&file.sensor),
                applied.corrected.iter().map(|value| scale * value).collect(),
            ),
            (
                "extrapolated".to_string(),
                applied.extrapolated.iter().map(|out| f64::from(u8::from(*out))).collect(),
            ),
        ];
        Ok((Columns::new(columns, notes, said.to_string()), recording.notes))
    })?;
    warn_of_times(py, &read)?;
    python::warn(py, columns.warnings())?;
    Ok(columns)
}
