//! Cells that cannot be readings: found before anything is fitted, named with their line, and left out.
//!
//! A cell is held against what the other rows say: its neighbours in time, the same angle in other passes, and the
//! other columns of its own row. Only a cell that stands alone is listed; several rows in a row that are high together
//! are physics, and so is what comes again in other passes.

mod base;
mod channels;
mod clock;
mod culprit;
mod dependence;
mod deviation;
mod findings;
mod gross;
pub mod left;
pub mod limits;
pub mod moving;
mod repeated;
mod scale;
mod trend;

pub(crate) use scale::resolution;

use std::borrow::Cow;

use serde::Serialize;

use crate::error_model::Sensor;
use crate::recording::{Note, Place, Recording, RecordingError};
use channels::Channels;

/// A cell that cannot be a reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BadRow {
    /// Its line in the file, the header being line 1.
    pub line: u64,
    /// Its column.
    pub column: String,
    /// What stands there.
    pub value: String,
    /// Why it cannot be a reading, with how far it is from what the other rows say.
    pub reason: String,
}

/// A recording without the rows that cannot be readings.
#[derive(Debug, Clone)]
pub struct Screened<'a> {
    /// The other rows; name, hash and line numbers are those of the whole file. Borrowed where all of them are readings.
    pub recording: Cow<'a, Recording>,
    /// Which rows of the whole recording they are.
    pub kept: Vec<usize>,
    /// The cells for whose sake the others were left out, in the order of the file.
    pub bad_rows: Vec<BadRow>,
    /// What else was noticed, and removes nothing: gaps, repeated times, stuck or saturated stretches, a coarse
    /// resolution.
    pub notes: Vec<String>,
}

/// A cell that is to be listed, by its row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    pub row: usize,
    pub column: String,
    pub value: f64,
    pub reason: String,
    /// Multiples of the scatter, for the order of the search.
    pub size: f64,
}

impl Fault {
    pub fn new(row: usize, column: &str, value: f64, size: f64, reason: String) -> Fault {
        Fault { row, column: column.to_string(), value, reason, size }
    }
}

/// Finds the cells that cannot be readings and leaves their rows out.
///
/// # Errors
/// [`RecordingError::TooManyFaults`] where more than a tenth of the rows are affected.
pub fn screen<'a>(recording: Cow<'a, Recording>, sensor: &Sensor) -> Result<Screened<'a>, RecordingError> {
    let faults = find(&recording, sensor);
    check(&recording, &faults)?;
    let kept = without(recording.rows(), &faults);
    let bad_rows = faults.iter().map(|fault| listed(&recording, fault)).collect();
    let clean =
        if kept.len() == recording.rows() { recording } else { Cow::Owned(selected(&recording, &kept)) };
    let notes = findings::notes(&clean);
    Ok(Screened { recording: clean, kept, bad_rows, notes })
}

/// The cells that cannot be readings, in the order of the file.
pub fn bad_rows(recording: &Recording, sensor: &Sensor) -> Vec<BadRow> {
    find(recording, sensor).iter().map(|fault| listed(recording, fault)).collect()
}

/// The cells that cannot be readings, in the order of the file; no further ones are looked for once too much of the
/// recording is affected.
pub(crate) fn find(recording: &Recording, sensor: &Sensor) -> Vec<Fault> {
    let rows = recording.rows();
    let mut faults = repeated::faults(recording);
    faults.extend(gross::faults(recording));
    faults.extend(clock::faults(recording, &without(rows, &faults)));
    let mut bad = vec![false; rows];
    faults.iter().for_each(|fault| bad[fault.row] = true);
    let stretches = rows.div_ceil(limits::STRETCH).max(1);
    let stretch = |k: usize| k * rows / stretches..(k + 1) * rows / stretches;
    let by_rows = (0..stretches).flat_map(|k| beside_others(recording, sensor, &bad, stretch(k))).collect();
    faults.extend(alone(by_rows, rows));
    faults.sort_by(|a, b| (a.row, &a.column).cmp(&(b.row, &b.column)));
    faults
}

/// The cells of a stretch of rows that cannot be readings beside the other rows of it, those that are `bad` left out.
fn beside_others(
    recording: &Recording,
    sensor: &Sensor,
    bad: &[bool],
    stretch: std::ops::Range<usize>,
) -> Vec<Fault> {
    let mut kept: Vec<usize> = stretch.clone().filter(|row| !bad[*row]).collect();
    let mut by_rows: Vec<Fault> = Vec::new();
    for _ in 0..limits::ROUNDS {
        if kept.len() < limits::FEWEST_ROWS || too_many(stretch.len() - kept.len(), stretch.len()) {
            break;
        }
        let rest = recording.select(&kept);
        let channels = Channels::of(&rest, sensor);
        let mut found = culprit::faults(&channels);
        let largest = found.iter().fold(0.0_f64, |largest, fault| largest.max(fault.size));
        // A cell far out draws the prediction of others with it: those are judged again without it.
        found.retain(|fault| fault.size >= limits::TOGETHER * largest);
        if found.is_empty() {
            break;
        }
        by_rows.extend(found.into_iter().map(|fault| Fault { row: kept[fault.row], ..fault }));
        kept.retain(|row| by_rows.iter().all(|fault| fault.row != *row));
    }
    by_rows
}

/// Whether so many of the rows are affected that it is no matter of single cells.
fn too_many(affected: usize, rows: usize) -> bool {
    affected > 1 && affected as f64 > limits::MOST_AFFECTED * rows as f64
}

/// The faults without those of a column that follow each other row by row: found one after the other, each beside the
/// end that the one before left, they are a course of the column and no single cells.
fn alone(mut faults: Vec<Fault>, rows: usize) -> Vec<Fault> {
    faults.sort_by(|a, b| (&a.column, a.row).cmp(&(&b.column, b.row)));
    let runs = faults.chunk_by(|a, b| a.column == b.column && b.row == a.row + 1);
    let is_course = |run: &&[Fault]| {
        let at_end = run[0].row == 0 || run[run.len() - 1].row + 1 == rows;
        run.len() > if at_end { limits::LONGEST_RUN_AT_END } else { limits::LONGEST_RUN }
    };
    runs.filter(|run| !is_course(run)).flatten().cloned().collect()
}

/// The rows of `kept`; a note on time that runs backward is dropped where it no longer does.
fn selected(recording: &Recording, kept: &[usize]) -> Recording {
    let mut clean = recording.select(kept);
    if clean.time_s.windows(2).all(|pair| pair[0] <= pair[1]) {
        clean.notes.retain(|note| !matches!(note, Note::TimeBackward { .. }));
    }
    clean
}

/// A fault as it is reported.
pub(crate) fn listed(recording: &Recording, fault: &Fault) -> BadRow {
    BadRow {
        line: recording.line(fault.row),
        column: fault.column.clone(),
        value: shown(fault.value),
        reason: fault.reason.clone(),
    }
}

/// A number as it may have stood in the file.
pub fn shown(value: f64) -> String {
    if value != 0.0 && !(1e-6..1e15).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// The rows that no fault is in.
pub(crate) fn without(rows: usize, faults: &[Fault]) -> Vec<usize> {
    let mut bad = vec![false; rows];
    faults.iter().for_each(|fault| bad[fault.row] = true);
    (0..rows).filter(|row| !bad[*row]).collect()
}

fn check(recording: &Recording, faults: &[Fault]) -> Result<(), RecordingError> {
    let rows = recording.rows();
    let affected = rows - without(rows, faults).len();
    match faults.iter().min_by_key(|fault| fault.row) {
        Some(first) if too_many(affected, rows) => {
            let BadRow { line, column, value, reason } = listed(recording, first);
            let place = Place { file: recording.file.clone(), line, column };
            Err(RecordingError::TooManyFaults { place, found: format!("{value} ({reason})"), affected, rows })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
