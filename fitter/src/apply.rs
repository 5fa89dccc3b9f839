//! `apply`: the corrected reading of every row of a recording.
//!
//! Inside the valid range that is θ − Δθ − terms (Eq. 13 with the terms of further effects). Outside it a
//! polynomial of high order is worth nothing: there a line goes on from its end with its mean slope, and of
//! the terms only those that extrapolate (constant, slope, periodic).
//!
//! Play, lags and rates remember the rows before. A cell that cannot be a reading must not be remembered: [`apply_screened`]
//! corrects every other row as if its row were not there.

use std::io::Write;
use std::path::Path;

use crate::coefficients::Coefficients;
use crate::error_model::Sensor;
use crate::faults::{self, BadRow};
use crate::output::{OutputError, write_whole};
use crate::recording::Recording;
use crate::statistics::ends;
use crate::terms::{self, Evaluated, Observables, Term, depends_on_angle};

errors! {
    /// Why coefficients cannot be applied to a recording.
    #[derive(Debug)]
    pub enum ApplyError {
        OtherSensor { file: String, recording: &'static str, model: &'static str } =>
            at(file) says("has the columns of {recording}, and the coefficients are those of {model}")
            mend("give the coefficients of this sensor");
        MissingColumn { file: String, column: String, effect: String } =>
            at(file) says("column `{column}` is missing, which `{effect}` of the coefficients depends on")
            mend("record it, or map it: {column}=<your column>") by(map);
        Unit { file: String, variable: String, from: f64, to: f64, valid_from: f64, valid_to: f64 } =>
            at(file)
            found("readings {variable} from {from:.6} to {to:.6}, a thousand times beyond the calibrated \
                range {valid_from:.6} to {valid_to:.6}")
            expected("the same unit") mend("convert them");
        /// To verify a correction.
        NoReference { file: String } =>
            at(file) says("has no reference") expected("one in every row") mend("a verification needs it");
    }
}

/// Refuses a recording that lacks a column which a term of the coefficients reads.
///
/// # Errors
/// [`ApplyError::MissingColumn`], for the first of them.
pub fn check_columns(recording: &Recording, coefficients: &Coefficients) -> Result<(), ApplyError> {
    let observables = Observables { recording, sensor: &coefficients.sensor };
    for term in &coefficients.terms {
        for observable in term.operator.observables() {
            if observables.get(observable).is_err() {
                return Err(ApplyError::MissingColumn {
                    file: recording.file.clone(),
                    column: observable.to_string(),
                    effect: term.effect.clone(),
                });
            }
        }
    }
    Ok(())
}

/// What a reader of the corrected angles should know.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // what the variants say of them
pub enum ApplyNote {
    /// Rows outside the valid range.
    Extrapolated { rows: usize, of: usize, from: f64, to: f64, valid_from: f64, valid_to: f64, unit: String },
    /// A term needs a column that is not there.
    MissingColumn { effect: String, column: String },
    /// A term holds on the recording it was found in only.
    OtherRecording { effect: String },
    /// A term was left out on rows with a blank.
    Blank { effect: String, rows: usize },
    /// Cells that cannot be readings: the first of them, and how many rows have one.
    Bad { first: BadRow, rows: usize },
}

impl std::fmt::Display for ApplyNote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ApplyNote::Extrapolated { rows, of, from, to, valid_from, valid_to, unit } => write!(
                f,
                "{rows} of {of} rows lie outside the calibrated range {valid_from} to {valid_to} {unit} (readings {from} \
                 to {to} {unit}): there only a constant, a slope and periodic terms are used"
            ),
            ApplyNote::MissingColumn { effect, column } => write!(
                f,
                "column `{column}` is missing, which `{effect}` depends on: that effect is not corrected"
            ),
            ApplyNote::OtherRecording { effect } => write!(
                f,
                "`{effect}` holds only on the recording it was found in and is left out on this one"
            ),
            ApplyNote::Blank { effect, rows } => {
                write!(
                    f,
                    "{rows} rows have a blank in a column that `{effect}` depends on: not corrected there"
                )
            }
            ApplyNote::Bad { first: BadRow { line, column, value, reason }, rows } => {
                let more = match rows - 1 {
                    0 => String::new(),
                    more => format!(", and {more} rows more have such a cell"),
                };
                write!(
                    f,
                    "line {line}, {column} {value}: {reason}{more}; marked in the column `extrapolated`, and no other row \
                     depends on it"
                )
            }
        }
    }
}

/// Corrected readings of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Applied {
    /// Corrected angle in radians; direct: corrected reading in the sensor's unit. One per row.
    pub corrected: Vec<f64>,
    /// Whether the row lies outside the valid range, or has a cell that cannot be a reading.
    pub extrapolated: Vec<bool>,
    /// The cells that cannot be readings, of the columns that the correction uses.
    pub bad_rows: Vec<BadRow>,
    /// What a reader should know.
    pub notes: Vec<ApplyNote>,
}

/// Corrects every row of a recording, each of which is taken as it is.
///
/// # Errors
/// [`ApplyError`] if the recording is of another kind of sensor, or in another unit.
pub fn apply(recording: &Recording, coefficients: &Coefficients) -> Result<Applied, ApplyError> {
    without(recording, coefficients, Vec::new())
}

/// Corrects every row of a recording. What the correction remembers passes over rows with a cell that cannot be a
/// reading; they have the terms of the row before.
///
/// # Errors
/// As [`apply`].
pub fn apply_screened(recording: &Recording, coefficients: &Coefficients) -> Result<Applied, ApplyError> {
    // Without terms no row depends on another: there only a reading matters for which the whole recording would pass
    // for one in another unit.
    let needed = !coefficients.terms.is_empty()
        || in_another_unit(range(recording, 0..recording.rows()), coefficients);
    let bad = if needed { faults::bad_rows(recording, &coefficients.sensor) } else { Vec::new() };
    apply_passing_over(recording, coefficients, &bad)
}

/// As [`apply_screened`], where the cells that cannot be readings are known already. Those in columns that the correction
/// does not use are no matter.
///
/// # Errors
/// As [`apply`].
pub fn apply_passing_over(
    recording: &Recording,
    coefficients: &Coefficients,
    bad: &[BadRow],
) -> Result<Applied, ApplyError> {
    // Lags and rates use the time and the passes.
    let mut used = vec!["t_s", "pass", "x1_mm", "x2_mm", "measured"];
    used.extend(coefficients.terms.iter().flat_map(|term| term.operator.observables()));
    let is_used = |cell: &&BadRow| used.contains(&cell.column.as_str());
    without(recording, coefficients, bad.iter().filter(is_used).cloned().collect())
}

/// The smallest and the largest reading of some rows.
fn range(recording: &Recording, rows: impl Iterator<Item = usize>) -> (f64, f64) {
    ends(rows.map(|row| recording.reading(row)))
}

/// An eddy-current pair cannot leave its calibrated range by much; a direct sensor may be anywhere.
fn in_another_unit((from, to): (f64, f64), coefficients: &Coefficients) -> bool {
    let valid = &coefficients.valid_range;
    let (largest, calibrated) = (from.abs().max(to.abs()), valid.from.abs().max(valid.to.abs()));
    matches!(coefficients.sensor, Sensor::EddyCurrentPair { .. }) && largest > 100.0 * calibrated
}

/// Corrects every row, as if those of the bad cells were not there.
fn without(
    recording: &Recording,
    coefficients: &Coefficients,
    bad_rows: Vec<BadRow>,
) -> Result<Applied, ApplyError> {
    let sensor = &coefficients.sensor;
    let file = || recording.file.clone();
    if let Some(recording) = recording.readings.other_than(sensor) {
        return Err(ApplyError::OtherSensor { file: file(), recording, model: sensor.kind() });
    }
    let valid = &coefficients.valid_range;
    let rows = recording.rows();
    let is_bad = |row: &usize| bad_rows.binary_search_by_key(&recording.line(*row), |bad| bad.line).is_ok();
    let (passed_over, kept): (Vec<usize>, Vec<usize>) = (0..rows).partition(is_bad);
    let (from, to) = range(recording, kept.iter().copied());
    if in_another_unit((from, to), coefficients) {
        let (variable, valid_from, valid_to) = (valid.variable.clone(), valid.from, valid.to);
        return Err(ApplyError::Unit { file: file(), variable, from, to, valid_from, valid_to });
    }
    let same = recording.sha256 == coefficients.recording.sha256;
    let evaluate = |terms: &[Term], recording: &Recording| {
        terms::evaluate(terms, &Observables { recording, sensor }, same)
    };
    let evaluated = if kept.len() == rows {
        evaluate(&coefficients.terms, recording)
    } else {
        // No row after a bad one depends on it. What does not remember, and does not read its bad cell, has its own value there;
        // what does, that of the row before. A bad reading is still where the angle is, more or less.
        let pair = matches!(sensor, Sensor::EddyCurrentPair { .. });
        let bad = |name: &str| !depends_on_angle(name) && bad_rows.iter().any(|bad| bad.column == name);
        let (held, own): (Vec<_>, Vec<_>) =
            coefficients.terms.iter().cloned().partition(|Term { operator, .. }| {
                operator.remembers(pair) || operator.observables().into_iter().any(bad)
            });
        let of_kept = evaluate(&held, &recording.select(&kept)).spread(&kept, rows);
        evaluate(&own, recording).and(of_kept)
    };
    let model = coefficients.error_model();
    let scale = sensor.per_internal();
    let mut applied = Applied {
        corrected: Vec::with_capacity(rows),
        extrapolated: Vec::with_capacity(rows),
        bad_rows,
        notes: Vec::new(),
    };
    for row in 0..rows {
        let reading = recording.reading(row);
        // Of a sensor that turns everything repeats with the turn; what was taken off is put back at the end.
        let (reading, turns) = match (&coefficients.turn, sensor.revolution()) {
            (Some(turn), _) => turn.within(reading),
            (None, Some(turn)) => valid.on_its_turn(reading, turn),
            _ => (reading, 0.0),
        };
        let inside = coefficients.whole_turn() || valid.contains(reading);
        let (base, explicit) = if inside {
            (model.error(reading), evaluated.inside[row])
        } else {
            (coefficients.error_beyond(reading), evaluated.outside[row])
        };
        let corrected = sensor.calculated(reading) - base;
        let corrected = if coefficients.terms.is_empty() {
            corrected
        } else {
            evaluated.solve_periodic(scale * corrected - explicit) / scale
        };
        applied.corrected.push(match (&coefficients.turn, sensor.revolution()) {
            (Some(turn), _) => turn.finish(corrected, turns),
            (None, Some(turn)) => corrected + turns * turn,
            _ => corrected,
        });
        applied.extrapolated.push(!inside);
    }
    passed_over.iter().for_each(|row| applied.extrapolated[*row] = false);
    applied.notes = notes(&applied, &evaluated, coefficients, (from, to));
    passed_over.iter().for_each(|row| applied.extrapolated[*row] = true);
    if let Some(first) = applied.bad_rows.first().cloned() {
        applied.notes.push(ApplyNote::Bad { first, rows: passed_over.len() });
    }
    Ok(applied)
}

fn notes(
    applied: &Applied,
    evaluated: &Evaluated,
    coefficients: &Coefficients,
    (from, to): (f64, f64),
) -> Vec<ApplyNote> {
    let mut notes = Vec::new();
    let rows = applied.extrapolated.iter().filter(|outside| **outside).count();
    if rows > 0 {
        let valid = &coefficients.valid_range;
        notes.push(ApplyNote::Extrapolated {
            rows,
            of: applied.extrapolated.len(),
            from,
            to,
            valid_from: valid.from,
            valid_to: valid.to,
            unit: coefficients.units.reading.clone(),
        });
    }
    let missing = evaluated.missing.iter().cloned();
    notes.extend(missing.map(|(effect, m)| ApplyNote::MissingColumn { effect, column: m.observable }));
    notes
        .extend(evaluated.other_recording.iter().cloned().map(|effect| ApplyNote::OtherRecording { effect }));
    notes.extend(evaluated.blank.iter().cloned().map(|(effect, rows)| ApplyNote::Blank { effect, rows }));
    notes
}

/// The name of the column that [`write()`] gives the corrected readings: `angle_arcsec`, `corrected_mm` ….
pub fn column_name(sensor: &Sensor) -> String {
    match sensor {
        Sensor::EddyCurrentPair { .. } => "angle_arcsec".to_string(),
        Sensor::Direct { unit, .. } => format!("corrected_{unit}"),
    }
}

/// Writes `t_s`, the corrected reading (arcseconds; direct: the sensor's unit) and `extrapolated` (0, or 1 of a row
/// outside the valid range or with a cell that cannot be a reading).
///
/// # Errors
/// [`OutputError`]; nothing is left behind.
pub fn write(
    path: &Path,
    recording: &Recording,
    sensor: &Sensor,
    applied: &Applied,
) -> Result<(), OutputError> {
    let scale = sensor.per_internal();
    write_whole(path, |file: &mut dyn Write| {
        writeln!(file, "t_s,{},extrapolated", column_name(sensor))?;
        for (row, corrected) in applied.corrected.iter().enumerate() {
            let outside = u8::from(applied.extrapolated[row]);
            match sensor {
                // A millionth of an arcsecond is far below anything that a recording holds.
                Sensor::EddyCurrentPair { .. } => {
                    writeln!(file, "{},{:.6},{outside}", recording.time_s[row], scale * corrected)?;
                }
                Sensor::Direct { .. } => {
                    writeln!(file, "{},{},{outside}", recording.time_s[row], corrected)?;
                }
            }
        }
        Ok(())
    })
}
