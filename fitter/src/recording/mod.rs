//! A static calibration recording: one row per settled reading, kept in columns.
//!
//! Columns and units are those of the recording format: `t_s`, `pass`, `direction`, optionally
//! `command_deg`, then `x1_mm`, `x2_mm`, `reference_arcsec` of an eddy-current pair or `measured`,
//! `reference` of a direct sensor. Any other numeric column is kept as a further observable.

#[cfg(feature = "fit")]
mod build;
mod checks;
mod dialect;
#[cfg(feature = "fit")]
mod fault;
#[cfg(feature = "fit")]
mod header;
#[cfg(feature = "fit")]
mod mapping;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "fit")]
mod read;

pub use dialect::Dialect;
#[cfg(feature = "fit")]
pub use fault::{Place, RecordingError};
#[cfg(feature = "fit")]
pub(crate) use header::nearest;
#[cfg(feature = "fit")]
pub use header::safe_column;
#[cfg(feature = "fit")]
pub use mapping::Mapping;
#[cfg(feature = "fit")]
pub use read::{Purpose, Reading};

/// A further observable that a mismatch may depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name in the header; it ends in the unit (`temperature_c`, `coil_a`).
    pub name: String,
    /// One value per row, NaN where the cell is blank.
    pub values: Vec<f64>,
}

/// What the sensor and the reference said, row by row.
#[derive(Debug, Clone, PartialEq)]
pub enum Readings {
    /// Two eddy-current probes and an autocollimator (Eq. 1–3).
    Pair {
        /// x₁ in millimetres.
        x1_mm: Vec<f64>,
        /// x₂ in millimetres.
        x2_mm: Vec<f64>,
        /// The autocollimator's reading in arcseconds; absent in a recording that is only to be corrected.
        reference_arcsec: Option<Vec<f64>>,
    },
    /// A sensor that reports the angle or position itself, in its own unit.
    Direct {
        /// The sensor's reading.
        measured: Vec<f64>,
        /// The reference's reading; absent in a recording that is only to be corrected.
        reference: Option<Vec<f64>>,
    },
}

/// Something that was noticed while reading and does not forbid a fit.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// Time runs backward at `line`, from `from_s` to `to_s`.
    TimeBackward {
        /// Line of the earlier time.
        line: u64,
        /// Time of the row before, in seconds.
        from_s: f64,
        /// Time of that row, in seconds.
        to_s: f64,
    },
    /// A column that holds no numbers was left out.
    TextColumn {
        /// The column's name.
        column: String,
    },
    /// The file separates its columns, or writes its numbers, in another way than by commas and points.
    Dialect(Dialect),
    /// Columns were taken under other names, or converted.
    Mapped {
        /// As on the command line: `x1_mm=Probe1:um`.
        columns: Vec<String>,
    },
    /// No row has a pass number that lies between those of others.
    EmptyPass {
        /// The first such number.
        pass: i64,
        /// The smallest number of a pass.
        first: i64,
        /// The largest.
        last: i64,
    },
    /// A column that a fit needs is not there and a constant stands for it.
    Assumed {
        /// The column's name.
        column: &'static str,
    },
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Note::TimeBackward { line, from_s, to_s } => write!(
                f,
                "time runs backward at line {line} (from {from_s} s to {to_s} s): the fit does not use time, but \
                 nothing can be concluded about drift, lag or history"
            ),
            Note::Dialect(dialect) => dialect.fmt(f),
            Note::Mapped { columns } => write!(f, "columns taken as {}", columns.join(", ")),
            Note::TextColumn { column } => write!(f, "column `{column}` holds no numbers and is left out"),
            Note::EmptyPass { pass, first, last } => write!(
                f,
                "pass {pass} has no row, although passes {first} to {last} are there: the others are used as they are"
            ),
            Note::Assumed { column } => {
                write!(f, "column `{column}` is missing: all rows are taken as one forward pass")
            }
        }
    }
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
    pub time_s: Vec<f64>,
    /// Number of the pass (repeat).
    pub pass: Vec<i32>,
    /// +1 forward, −1 backward.
    pub direction: Vec<i8>,
    /// Commanded angle in degrees, NaN where blank.
    pub command_deg: Option<Vec<f64>>,
    /// Sensor and reference.
    pub readings: Readings,
    /// All further numeric columns, in the order of the header.
    pub further: Vec<Column>,
    /// What was noticed while reading.
    pub notes: Vec<Note>,
    /// Where the rows stand in the file.
    pub(crate) lines: checks::Lines,
}

impl Recording {
    /// The recording that holds the given rows only, in the given order: held-out passes, for example. It
    /// keeps the name and the hash of the whole.
    pub fn select(&self, rows: &[usize]) -> Recording {
        fn pick<T: Copy>(values: &[T], rows: &[usize]) -> Vec<T> {
            rows.iter().map(|row| values[*row]).collect()
        }
        let pick_some = |values: &Option<Vec<f64>>| values.as_ref().map(|values| pick(values, rows));
        let mut lines = checks::Lines::default();
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
        let mut passes = Vec::new();
        // Rows of a pass stand together, so that nearly every row is the one before.
        let mut last = None;
        for &pass in &self.pass {
            if last != Some(pass) {
                if let Err(at) = passes.binary_search(&pass) {
                    passes.insert(at, pass);
                }
                last = Some(pass);
            }
        }
        passes
    }

    /// The further observable of that name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.further.iter().find(|column| column.name == name).map(|column| column.values.as_slice())
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
