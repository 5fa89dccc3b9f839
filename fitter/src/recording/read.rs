//! From a table to a calibration recording.

use std::path::Path;

use super::direction::{self, WORDS};
use super::{Mapping, Note, Readings, Recording, RecordingError};
use crate::error_model::Sensor;
use crate::table::{Cells, Dialect, Header, Naming, Table, Use};

/// What a recording is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To fit: time, pass, readings and reference are needed.
    Fit,
    /// To correct: time and readings are needed.
    Apply,
}

/// How a recording is to be read.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    /// What for.
    pub purpose: Purpose,
    /// Columns under other names and in other units.
    pub mappings: &'a [Mapping],
    /// The sensor: its unit is that of `measured` and `reference` where a mapping converts them.
    pub sensor: Option<&'a Sensor>,
}

const PAIR: [&str; 3] = ["x1_mm", "x2_mm", "reference_arcsec"];
const DIRECT: [&str; 2] = ["measured", "reference"];

impl Reading<'_> {
    /// Columns as the recording format names them.
    pub const fn plain(purpose: Purpose) -> Reading<'static> {
        Reading { purpose, mappings: &[], sensor: None }
    }

    /// Reads a table, its columns named and converted as wanted.
    fn table(
        &self,
        read: impl FnOnce(&Naming, &crate::table::Uses) -> Result<Table, RecordingError>,
    ) -> Result<Recording, RecordingError> {
        let units = match self.sensor {
            Some(Sensor::Direct { unit, .. }) => DIRECT.map(|name| (name, unit.as_str())).to_vec(),
            _ => Vec::new(),
        };
        let naming = Naming { mappings: self.mappings, units: &units, revolution: self.revolution() };
        self.recording(read(&naming, &|header| self.uses(header))?)
    }

    fn revolution(&self) -> Option<f64> {
        self.sensor.and_then(Sensor::revolution)
    }

    /// How the columns of a header are used.
    fn uses(&self, header: &Header) -> Result<Vec<Use>, RecordingError> {
        let first_of =
            |wanted: &[&str]| wanted.iter().find(|name| header.has(name)).map(|name| name.to_string());
        let (pair, direct) = (first_of(&PAIR), first_of(&DIRECT));
        let is_direct = direct.is_some();
        if let (Some(pair), Some(direct)) = (pair, direct) {
            return Err(RecordingError::TwoSensors { at: header.at.clone(), pair, direct });
        }
        let readings = if is_direct { &DIRECT[..] } else { &PAIR };
        let needed = match self.purpose {
            Purpose::Fit => [&["t_s", "pass"], readings].concat(),
            Purpose::Apply => [&["t_s"], &readings[..readings.len() - 1]].concat(),
        };
        header.require(&needed)?;
        let used = |name: &String| match name.as_str() {
            "pass" => Use::Whole,
            "direction" => Use::Words(WORDS),
            "t_s" => Use::Time,
            name if PAIR.contains(&name) || DIRECT.contains(&name) => Use::Needed,
            _ => Use::Optional,
        };
        Ok(header.names.iter().map(used).collect())
    }

    /// The recording of a table; its notes are what was noticed.
    fn recording(&self, mut table: Table) -> Result<Recording, RecordingError> {
        let rows = table.rows;
        let mut notes = Vec::new();
        if table.dialect != Dialect::PLAIN {
            notes.push(Note::Dialect(table.dialect));
        }
        if !self.mappings.is_empty() {
            notes.push(Note::Mapped { columns: self.mappings.iter().map(Mapping::to_string).collect() });
        }
        let time_s = table.take_time();
        let started = table.started.take();
        notes.extend(started.map(Note::since));
        if let Some(row) = (1..rows).find(|row| time_s[*row] < time_s[row - 1]) {
            let (from_s, to_s) = (time_s[row - 1], time_s[row]);
            notes.push(Note::TimeBackward { line: table.lines.of(row), from_s, to_s });
        }
        let pass = match table.take("pass") {
            Some(pass) => pass.iter().map(|number| *number as i32).collect(),
            None => {
                notes.push(Note::Assumed { column: "pass", taken: "all rows are taken as one pass" });
                vec![0; rows]
            }
        };
        let readings = match table.take("measured") {
            Some(measured) => Readings::Direct { measured, reference: table.take("reference") },
            None => Readings::Pair {
                x1_mm: table.take("x1_mm").unwrap_or_default(),
                x2_mm: table.take("x2_mm").unwrap_or_default(),
                reference_arcsec: table.take("reference_arcsec"),
            },
        };
        let directions = table.take("direction");
        let mut recording = Recording {
            file: table.file.clone(),
            sha256: std::mem::take(&mut table.sha256),
            time_s,
            pass,
            direction: Vec::new(),
            command_deg: table.take("command_deg"),
            readings,
            further: std::mem::take(&mut table.columns),
            notes,
            lines: std::mem::take(&mut table.lines),
        };
        recording.direction = match directions {
            Some(values) => direction::of_numbers(&values).map_err(|row| RecordingError::Direction {
                place: table.header.place(recording.line(row), "direction"),
                found: values[row].to_string(),
            })?,
            None => {
                let taken = "it is taken from the motion of the readings";
                recording.notes.push(Note::Assumed { column: "direction", taken });
                let readings = (0..rows).map(|row| recording.reading(row));
                direction::of_motion(readings, &recording.pass, self.revolution())
            }
        };
        let without = table.without_numbers.into_iter().map(|column| Note::TextColumn { column });
        recording.notes.extend(without);
        if self.purpose == Purpose::Fit {
            recording.notes.extend(recording.empty_pass());
        }
        Ok(recording)
    }
}

impl Recording {
    /// Reads the recording at `path` for a fit; `-` is standard input.
    ///
    /// # Errors
    /// One of [`RecordingError`], with the line and the column where there is one.
    pub fn read(path: &Path) -> Result<Recording, RecordingError> {
        Recording::read_for(path, Purpose::Fit, &mut |_| {})
    }

    /// As [`Recording::read`], for a given purpose; `progress` is told the number of bytes read so far.
    pub fn read_for(
        path: &Path,
        purpose: Purpose,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Recording, RecordingError> {
        Recording::read_as(path, &Reading::plain(purpose), progress)
    }

    /// As [`Recording::read_for`], with columns mapped and converted.
    ///
    /// # Errors
    /// As [`Recording::read`], and those of a mapping that does not fit.
    pub fn read_as(
        path: &Path,
        reading: &Reading,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Recording, RecordingError> {
        reading.table(|naming, uses| Table::read(path, naming, uses, progress))
    }

    /// Reads a recording from bytes; `file` is the name that stands in messages and provenance, and a name
    /// that ends in `.gz` is decompressed.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Recording, RecordingError> {
        Reading::plain(Purpose::Fit).table(|naming, uses| Table::from_bytes(file, bytes, naming, uses))
    }

    /// Takes columns in memory for a recording, in a copy only where they are converted; `file` is as in
    /// [`Table::of_columns`].
    ///
    /// ```
    /// use fitter::Recording;
    /// use fitter::recording::{Purpose, Reading};
    /// use fitter::table::{Cells, IN_MEMORY};
    ///
    /// let column = |name: &str, values: [f64; 2]| (name.to_string(), Cells::Numbers(values.to_vec().into()));
    /// let columns = vec![column("t_s", [0.0, 0.1]), column("measured", [10.0, 20.0])];
    /// let recording = Recording::of_columns(IN_MEMORY, columns, &Reading::plain(Purpose::Apply))?;
    /// assert_eq!(recording.reading(1), 20.0);
    /// # Ok::<(), fitter::RecordingError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Recording::read_as`], and [`RecordingError::Lengths`].
    pub fn of_columns(
        file: &str,
        columns: Vec<(String, Cells)>,
        reading: &Reading,
    ) -> Result<Recording, RecordingError> {
        reading.table(|naming, uses| Table::of_columns(file, columns, naming, uses))
    }

    /// A pass number between the smallest and the largest that no row has. In a recording of one direction only the
    /// passes of the other are rightly missing.
    fn empty_pass(&self) -> Option<Note> {
        let passes = self.passes();
        if self.direction.iter().all(|d| *d == self.direction[0]) {
            return None;
        }
        let gap = passes.windows(2).find(|pair| i64::from(pair[1]) > i64::from(pair[0]) + 1)?;
        Some(Note::EmptyPass {
            pass: i64::from(gap[0]) + 1,
            first: i64::from(passes[0]),
            last: i64::from(passes[passes.len() - 1]),
        })
    }
}
