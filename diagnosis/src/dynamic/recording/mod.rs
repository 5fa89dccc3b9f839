//! A dynamic recording: equidistant rows of drives and positions, in one or several runs.
//!
//! Columns: `t_s`, `drive` (or `drive_1`, `drive_2`, …), `position` (or `position_1`, …); optional `run`,
//! `period`, `amplitude`, `command`. Any other column is ignored.

mod checks;
mod faults;
mod read;

use std::ops::Range;

use super::fault::DynamicError;

/// A checked dynamic recording, columnar; every number in it is finite.
#[derive(Debug, Clone, PartialEq)]
pub struct DynamicRecording {
    /// File name without its folder.
    pub file: String,
    /// SHA-256 of the file's bytes as they lie on disk, hexadecimal.
    pub sha256: String,
    /// Time from one row to the next, s.
    pub step_s: f64,
    /// Time of every row, s.
    pub t_s: Vec<f64>,
    /// The drives, one column each, in drive units.
    pub drives: Vec<Vec<f64>>,
    /// The positions, one column each, in position units.
    pub positions: Vec<Vec<f64>>,
    /// Rows of every run, in order, all of the same length.
    pub runs: Vec<Range<usize>>,
    /// Numbers of the runs as they stand in the file (0 where there is no such column).
    pub run_numbers: Vec<i64>,
    /// Number of the period of every row, where the excitation is periodic and in steady state.
    pub period: Option<Vec<i64>>,
    /// Amplitude of the excitation of every row.
    pub amplitude: Option<Vec<f64>>,
    /// What the controller followed, from the column that the plant names.
    pub command: Option<Vec<f64>>,
    /// Samples that cannot be readings; what the samples before and after say stands in their place.
    pub bad_rows: Vec<fitter::faults::BadRow>,
}

impl DynamicRecording {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.t_s.len()
    }

    /// Rows at the start of every run that give its initial state and are not scored: 50, or none in a
    /// periodic steady state.
    pub fn unscored(&self) -> usize {
        if self.period.is_some() { 0 } else { 50 }
    }

    /// Whether a row is scored.
    pub fn scored(&self, row: usize) -> bool {
        let start = self.runs.iter().find(|r| r.contains(&row)).map_or(0, |r| r.start);
        row >= start + self.unscored()
    }

    /// Refuses `other` as a held-out recording of the same device where its rate or channels differ.
    ///
    /// # Errors
    /// [`DynamicError::Rate`], [`DynamicError::OtherChannels`].
    pub fn comparable(&self, other: &DynamicRecording) -> Result<(), DynamicError> {
        if (other.step_s / self.step_s - 1.0).abs() > 1e-3 {
            return Err(DynamicError::Rate {
                file: other.file.clone(),
                found: other.step_s,
                expected: self.step_s,
                recording: self.file.clone(),
            });
        }
        let channels =
            |r: &DynamicRecording| format!("{} drives and {} positions", r.drives.len(), r.positions.len());
        if channels(other) != channels(self) {
            return Err(DynamicError::OtherChannels {
                file: other.file.clone(),
                found: channels(other),
                expected: channels(self),
                recording: self.file.clone(),
            });
        }
        Ok(())
    }
}
