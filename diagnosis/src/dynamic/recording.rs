//! A dynamic recording: equidistant rows of drives and positions, in one or several runs.
//!
//! Columns: `t_s`, `drive` (or `drive_1`, `drive_2`, …), `position` (or `position_1`, …); optional `run`,
//! `period`, `amplitude`, `command`. A further column whose name ends in a unit may be an input of a plant in equations; any
//! other is ignored.

use std::ops::Range;
use std::path::Path;

use fitter::RecordingError;
use fitter::faults::moving;
use fitter::recording::Note;
use fitter::table::{Cells, Header, Lines, Mapping, Naming, Place, Table, Uses, Values, family};
use motion::Series;

use crate::DiagnosisError;
use crate::thresholds::dynamic::recording::LEAST_ROWS;

/// How a recording is read: what the plant says of it, and columns under other names.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reading<'a> {
    /// The unit into which a mapped `position` is converted.
    pub position_unit: &'a str,
    /// The unit into which a mapped `drive` is converted.
    pub drive_unit: &'a str,
    /// The column that the controller followed, where there is one.
    pub command: Option<&'a str>,
    /// Columns under other names and in other units.
    pub mappings: &'a [Mapping],
    /// Whether the plant is stated in equations: it may move by itself, and have limits of its own.
    pub in_equations: bool,
}

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
    pub t_s: Values,
    /// The drives, one column each, in drive units.
    pub drives: Vec<Values>,
    /// The positions, one column each, in position units.
    pub positions: Vec<Values>,
    /// Further columns that may be inputs.
    pub further: Vec<(String, Values)>,
    /// Rows of every run, in order, all of the same length.
    pub runs: Vec<Range<usize>>,
    /// Number of the period of every row, where the excitation is periodic and in steady state.
    pub period: Option<Vec<i64>>,
    /// Amplitude of the excitation of every row.
    pub amplitude: Option<Values>,
    /// What the controller followed, from the column that the plant names.
    pub command: Option<Values>,
    /// Samples that cannot be readings; what the samples before and after say stands in their place.
    pub bad_rows: Vec<fitter::faults::BadRow>,
    /// What was noticed while reading.
    pub notes: Vec<Note>,
}

impl DynamicRecording {
    /// One run of one axis, of which nothing else is known.
    #[cfg(test)]
    pub(super) fn made(step_s: f64, drive: Vec<f64>, position: Vec<f64>) -> DynamicRecording {
        let rows = drive.len();
        DynamicRecording {
            file: String::new(),
            sha256: String::new(),
            step_s,
            t_s: (0..rows).map(|k| k as f64 * step_s).collect::<Vec<_>>().into(),
            drives: vec![drive.into()],
            positions: vec![position.into()],
            further: Vec::new(),
            runs: vec![0..rows; 1],
            period: None,
            amplitude: None,
            command: None,
            bad_rows: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Reads the recording at `path`; `-` is standard input.
    ///
    /// # Errors
    /// One of [`DiagnosisError`].
    pub fn read(path: &Path, reading: &Reading) -> Result<DynamicRecording, DiagnosisError> {
        DynamicRecording::table(reading, |naming, uses| Table::read(path, naming, uses, &mut |_| {}))
    }

    /// Takes columns in memory for a recording; `file` is as in [`Table::of_columns`].
    ///
    /// # Errors
    /// One of [`DiagnosisError`].
    pub fn of_columns(
        file: &str,
        columns: Vec<(String, Cells)>,
        reading: &Reading,
    ) -> Result<DynamicRecording, DiagnosisError> {
        DynamicRecording::table(reading, |naming, uses| Table::of_columns(file, columns, naming, uses))
    }

    fn table(
        reading: &Reading,
        read: impl FnOnce(&Naming, &Uses) -> Result<Table, RecordingError>,
    ) -> Result<DynamicRecording, DiagnosisError> {
        let units = [("position", reading.position_unit), ("drive", reading.drive_unit)];
        let naming = Naming { mappings: reading.mappings, units: &units, revolution: None };
        let further: Vec<&str> = ["amplitude"].into_iter().chain(reading.command).collect();
        let uses = |header: &Header| Series::uses(header, [!reading.in_equations, true], &further);
        DynamicRecording::of(read(&naming, &uses)?, reading)
    }

    fn of(mut table: Table, reading: &Reading) -> Result<DynamicRecording, DiagnosisError> {
        let command = match reading.command {
            None => None,
            Some(name) => match table.columns.iter().find(|column| column.name == name) {
                Some(column) => Some(column.values.clone()),
                None => {
                    let (found, at) = (table.header.listed(), table.header.at);
                    let column = name.into();
                    return Err(DiagnosisError::Feedback { at, column, found });
                }
            },
        };
        let series = Series::of(&mut table);
        let file = &table.header.file;
        let step_s = series.step_s(file, &table.lines, table.rounding, LEAST_ROWS)?;
        let runs = series.runs();
        let number = |run: &Range<usize>| series.run.as_ref().map_or(0, |numbers| numbers[run.start]);
        let expected = runs[0].len();
        if let Some(other) = runs.iter().find(|run| run.len() != expected) {
            let (file, found) = (file.clone(), other.len());
            let (run, first) = (number(other), number(&runs[0]));
            return Err(DiagnosisError::RunLength { file, run, found, first, expected });
        }
        let names = ["drive", "position"].map(|stem| family(&table.header.names, stem));
        let Series { t_s, period, mut drives, mut positions, mut further, started, .. } = series;
        further.retain(|(name, _)| reading.command != Some(name.as_str()));
        let mut bad_rows = Vec::new();
        for (group, names, is_position) in
            [(&mut drives, &names[0], false), (&mut positions, &names[1], true)]
        {
            for (values, name) in group.iter_mut().zip(names) {
                let place = |row| {
                    let (line, column) = (table.lines.of(row), name.clone());
                    Place { file: file.clone(), line, column }
                };
                bad_rows.extend(moving::mend(&place, values, &runs, is_position)?);
                check(file, &table.lines, values, (name, is_position), reading.in_equations)?;
            }
        }
        if drives.is_empty() {
            drives.push(vec![0.0; t_s.len()].into());
        }
        let amplitude = table.take("amplitude");
        let Table { file, sha256, .. } = table;
        Ok(DynamicRecording {
            file,
            sha256,
            step_s,
            t_s,
            drives,
            positions,
            further,
            runs,
            period,
            amplitude,
            command,
            bad_rows,
            notes: started.map(Note::since).into_iter().collect(),
        })
    }

    /// The recording with the columns that are inputs of a plant beyond its drives among the drives.
    pub fn with_inputs(&self, inputs: &[(String, physics::Unit)]) -> DynamicRecording {
        let column = |name: &String| self.further.iter().find(|(own, _)| own == name);
        let further = inputs.iter().skip(self.drives.len()).filter_map(|(name, _)| column(name));
        let drives = self.drives.iter().chain(further.map(|(_, values)| values)).cloned().collect();
        DynamicRecording { drives, ..self.clone() }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.t_s.len()
    }

    /// Rows at the start of every run that give its initial state and are not scored: 50, or none in a
    /// periodic steady state.
    pub fn unscored(&self) -> usize {
        if self.period.is_some() { 0 } else { 50 }
    }

    /// Rows of the first period of a run, where the excitation is periodic and in steady state.
    pub fn period_of(&self, run: &Range<usize>) -> Option<usize> {
        let period = self.period.as_ref()?;
        Some(run.clone().take_while(|row| period[*row] == period[run.start]).count())
    }

    /// That no plant follows its drive: the best leaves so much of the position's variance.
    pub fn lost(&self, percent: f64) -> DiagnosisError {
        DiagnosisError::NoPlant { file: self.file.clone(), percent }
    }

    /// The rows that are scored.
    pub fn scored_rows(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.runs.iter().flat_map(|run| run.start + self.unscored()..run.end)
    }

    /// Whether a row is scored.
    pub fn scored(&self, row: usize) -> bool {
        let start = self.runs.iter().find(|r| r.contains(&row)).map_or(0, |r| r.start);
        row >= start + self.unscored()
    }

    /// Refuses `other` as a held-out recording of the same device where its rate or channels differ.
    ///
    /// # Errors
    /// [`DiagnosisError::Rate`], [`DiagnosisError::OtherChannels`].
    pub fn comparable(&self, other: &DynamicRecording) -> Result<(), DiagnosisError> {
        if (other.step_s / self.step_s - 1.0).abs() > 1e-3 {
            return Err(DiagnosisError::Rate {
                file: other.file.clone(),
                found: other.step_s,
                expected: self.step_s,
                recording: self.file.clone(),
            });
        }
        let channels =
            |r: &DynamicRecording| format!("{} drives and {} positions", r.drives.len(), r.positions.len());
        if channels(other) != channels(self) {
            return Err(DiagnosisError::OtherChannels {
                file: other.file.clone(),
                found: channels(other),
                expected: channels(self),
                recording: self.file.clone(),
            });
        }
        Ok(())
    }
}

/// Refuses a drive or a position that stands still, and a position that is cut off, as far as the plant has neither.
fn check(
    file: &str,
    lines: &Lines,
    values: &[f64],
    (name, is_position): (&str, bool),
    in_equations: bool,
) -> Result<(), DiagnosisError> {
    let (file, column, value) = (file.to_string(), name.to_string(), values[0]);
    match values.iter().all(|other| *other == value) {
        true if is_position => return Err(DiagnosisError::ConstantPosition { file, column, value }),
        true if !in_equations => return Err(DiagnosisError::ConstantDrive { file, column, value }),
        _ => {}
    }
    match moving::cut_off(values) {
        Some((row, end, rows)) if is_position && !in_equations => {
            let (line, value) = (lines.of(row), values[row]);
            Err(DiagnosisError::Saturated { file, line, column, end, value, rows })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lent_columns_are_not_copied() {
        let wave = |frequency: f64| (0..1000).map(|k| (frequency * f64::from(k)).sin()).collect::<Vec<f64>>();
        let lent = [
            ("t_s", (0..1000).map(|k| f64::from(k) * 1e-3).collect()),
            ("drive", wave(0.1)),
            ("position", wave(0.07)),
            ("temperature_c", wave(0.01)),
        ]
        .map(|(name, values)| (name, std::sync::Arc::new(values)));
        let columns = lent
            .iter()
            .map(|(name, values)| (name.to_string(), Cells::Numbers(Values::lent(values.clone()))));
        let read = DynamicRecording::of_columns("table", columns.collect(), &Reading::default()).unwrap();
        // Nor are they where a plant in equations takes a column for an input.
        let inputs = ["u", "temperature_c"].map(|name| (name.to_string(), physics::Unit::one()));
        let taken = read.with_inputs(&inputs);
        for read in [&read.t_s, &read.drives[0], &read.positions[0], &read.further[0].1, &taken.drives[1]] {
            assert!(lent.iter().any(|(_, values)| values.as_ptr() == read.as_ptr()));
        }
    }
}
