//! A static calibration recording: one row per settled reading, kept in columns.
//!
//! Columns and units are those of the recording format: `t_s`, `pass`, `direction`, optionally
//! `command_deg`, then `x1_mm`, `x2_mm`, `reference_arcsec` of an eddy-current pair or `measured`,
//! `reference` of a direct sensor. Any other numeric column is kept as a further observable.

#[cfg(feature = "fit")]
mod direction;
mod note;
#[cfg(feature = "fit")]
mod read;

use std::collections::BTreeSet;

#[cfg(feature = "fit")]
use crate::error_model::Sensor;
use crate::table::Lines;
pub use crate::table::{Column, Dialect, Values};
#[cfg(feature = "fit")]
pub use crate::table::{Mapping, Place, RecordingError};
pub use note::Note;
#[cfg(feature = "fit")]
pub use read::{Purpose, Reading};

/// What the sensor and the reference said, row by row.
#[derive(Debug, Clone, PartialEq)]
pub enum Readings {
    /// Two eddy-current probes and an autocollimator (Eq. 1–3).
    Pair {
        /// x₁ in millimetres.
        x1_mm: Values,
        /// x₂ in millimetres.
        x2_mm: Values,
        /// The autocollimator's reading in arcseconds; absent in a recording that is only to be corrected.
        reference_arcsec: Option<Values>,
    },
    /// A sensor that reports the angle or position itself, in its own unit.
    Direct {
        /// The sensor's reading.
        measured: Values,
        /// The reference's reading; absent in a recording that is only to be corrected.
        reference: Option<Values>,
    },
}

/// A checked recording, columnar. Every vector has [`Recording::rows`] entries, and every number in it is
/// finite, except that a blank in an optional column is NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// File name without its folder.
    pub file: String,
    /// SHA-256 of the bytes of the file as it lies on disk (of a `.gz`, the compressed bytes), hexadecimal.
    pub sha256: String,
    /// Seconds since the start.
    pub time_s: Values,
    /// Number of the pass (repeat).
    pub pass: Vec<i32>,
    /// +1 forward, −1 backward.
    pub direction: Vec<i8>,
    /// Commanded angle in degrees, NaN where blank.
    pub command_deg: Option<Values>,
    /// Sensor and reference.
    pub readings: Readings,
    /// All further numeric columns, in the order of the header.
    pub further: Vec<Column>,
    /// What was noticed while reading.
    pub notes: Vec<Note>,
    /// Where the rows stand in the file.
    pub(crate) lines: Lines,
}

impl Readings {
    /// The sensor whose columns they are, in messages; none where `sensor` is of that kind.
    #[cfg(feature = "fit")]
    pub(crate) fn other_than(&self, sensor: &Sensor) -> Option<&'static str> {
        match (self, sensor) {
            (Readings::Pair { .. }, Sensor::Direct { .. }) => Some("an eddy-current pair"),
            (Readings::Direct { .. }, Sensor::EddyCurrentPair { .. }) => Some("a direct sensor"),
            _ => None,
        }
    }
}

impl Recording {
    /// The recording that holds the given rows only, in the given order: held-out passes, for example. It
    /// keeps the name and the hash of the whole.
    pub fn select(&self, rows: &[usize]) -> Recording {
        fn pick<T: Copy, V: FromIterator<T>>(values: &[T], rows: &[usize]) -> V {
            rows.iter().map(|row| values[*row]).collect()
        }
        let pick_some = |values: &Option<Values>| values.as_ref().map(|values| pick(values, rows));
        let mut lines = Lines::default();
        for (index, row) in rows.iter().enumerate() {
            lines.push(index, self.line(*row));
        }
        Recording {
            file: self.file.clone(),
            sha256: self.sha256.clone(),
            time_s: pick(&self.time_s, rows),
            pass: pick(&self.pass, rows),
            direction: pick(&self.direction, rows),
            command_deg: pick_some(&self.command_deg),
            readings: match &self.readings {
                Readings::Pair { x1_mm, x2_mm, reference_arcsec } => Readings::Pair {
                    x1_mm: pick(x1_mm, rows),
                    x2_mm: pick(x2_mm, rows),
                    reference_arcsec: pick_some(reference_arcsec),
                },
                Readings::Direct { measured, reference } => {
                    Readings::Direct { measured: pick(measured, rows), reference: pick_some(reference) }
                }
            },
            further: (self.further.iter())
                .map(|column| Column { name: column.name.clone(), values: pick(&column.values, rows) })
                .collect(),
            notes: self.notes.clone(),
            lines,
        }
    }

    /// The line of the file on which row `row` stands, the header being line 1.
    pub fn line(&self, row: usize) -> u64 {
        self.lines.of(row)
    }

    /// Number of readings.
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// The numbers of the passes, ascending.
    pub fn passes(&self) -> Vec<i32> {
        // Rows of a pass stand together, so that few are looked at.
        let runs = self.pass.chunk_by(|a, b| a == b).map(|run| run[0]);
        runs.collect::<BTreeSet<i32>>().into_iter().collect()
    }

    /// All columns of numbers but pass and direction, by name.
    pub fn columns(&self) -> Vec<(&str, &[f64])> {
        fn of<'a>(name: &'a str, values: Option<&'a Values>) -> Option<(&'a str, &'a [f64])> {
            values.map(|values| (name, &values[..]))
        }
        let [first, second, third] = match &self.readings {
            Readings::Pair { x1_mm, x2_mm, reference_arcsec } => [
                of("x1_mm", Some(x1_mm)),
                of("x2_mm", Some(x2_mm)),
                of("reference_arcsec", reference_arcsec.as_ref()),
            ],
            Readings::Direct { measured, reference } => {
                [of("measured", Some(measured)), of("reference", reference.as_ref()), None]
            }
        };
        let known = [of("t_s", Some(&self.time_s)), of("command_deg", self.command_deg.as_ref())];
        let further = self.further.iter().map(|column| (column.name.as_str(), &column.values[..]));
        known.into_iter().chain([first, second, third]).flatten().chain(further).collect()
    }

    /// The values of one of [`Recording::columns`].
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.columns().into_iter().find(|(other, _)| *other == name).map(|(_, values)| values)
    }

    /// The further observable of that name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.further.iter().find(|column| column.name == name).map(|column| &column.values[..])
    }

    /// The reading of row `row` that the error model is a polynomial of: s = x₂ − x₁ in millimetres, or the
    /// direct sensor's reading in its unit.
    pub fn reading(&self, row: usize) -> f64 {
        match &self.readings {
            Readings::Pair { x1_mm, x2_mm, .. } => x2_mm[row] - x1_mm[row],
            Readings::Direct { measured, .. } => measured[row],
        }
    }

    /// The reference of row `row` in arcseconds, or in the direct sensor's unit.
    pub fn reference(&self, row: usize) -> Option<f64> {
        match &self.readings {
            Readings::Pair { reference_arcsec: reference, .. } | Readings::Direct { reference, .. } => {
                reference.as_ref().map(|values| values[row])
            }
        }
    }
}
