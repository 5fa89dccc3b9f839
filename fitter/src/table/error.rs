//! What can be wrong with a recording before anything is computed from it: one message each, which says
//! where, what was found, what was expected and how to mend it.

use thiserror::Error;

use crate::input::{LimitError, Misplaced};
use crate::text_safety::UnsafeText;

/// A place in a recording's file.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The file as it was named.
    pub file: String,
    /// Line number, the first line being 1.
    pub line: u64,
    /// The column's name.
    pub column: String,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // A Parquet file has no lines: its rows are counted from 1.
        let word = if self.file.ends_with(".parquet") { "row" } else { "line" };
        write!(f, "{}, {word} {}, column `{}`", self.file, self.line, self.column)
    }
}

impl RecordingError {
    /// Of a reading that ended early: at a limit, or for what the system, or the decompression, says.
    pub fn of(file: &str, error: &std::io::Error, compressed: bool) -> RecordingError {
        let (file, reason) = (file.to_string(), error.to_string());
        match LimitError::of(error) {
            Some(limit) => RecordingError::Limit { file, limit },
            None if error.kind() == std::io::ErrorKind::NotFound => RecordingError::NotFound { file },
            None if compressed => RecordingError::DamagedGzip { file, reason },
            None => RecordingError::Unreadable { file, reason },
        }
    }
}

/// Which columns are missing, and how each can be given: by the name that is nearly it, or by any other.
fn absent(columns: &[(String, Option<String>)]) -> String {
    let names: Vec<String> = columns.iter().map(|(name, _)| format!("`{name}`")).collect();
    if let [name] = &names[..] {
        format!("column {name} is missing")
    } else {
        format!("columns {} are missing", names.join(", "))
    }
}

fn mend(columns: &[(String, Option<String>)]) -> String {
    let given = columns
        .iter()
        .map(|(name, similar)| format!("{name}={}", similar.as_deref().unwrap_or("<your column>")));
    let maps = given.collect::<Vec<_>>().join(" ");
    match columns {
        [(_, Some(similar))] => format!("rename `{similar}`, if that is what it is, or map it: {maps}"),
        [_] => format!("add it, or map the column that it is: {maps}"),
        _ => format!("add them, or map the columns that they are: {maps}"),
    }
}

/// Why a recording is refused.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say what the fields are
pub enum RecordingError {
    #[error("{file}: there is no such file; check the path of the recording")]
    NotFound { file: String },
    #[error("{file}: is a directory, expected a recording (CSV, CSV.gz or Parquet); name the file itself")]
    IsDirectory { file: String },
    #[error("{file}: cannot be read ({reason}); check the file's permissions and medium")]
    Unreadable { file: String, reason: String },
    #[error("{file}: {limit}")]
    Limit { file: String, limit: LimitError },
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    #[error("{file}: is empty, expected a header row and one row per reading; record or export it again")]
    Empty { file: String },
    #[error("{file}: has a header but no reading, expected one row per reading; export the rows as well")]
    NoRows { file: String },
    #[error(
        "{file}: ends in .gz but is not a whole gzip file ({reason}); copy it again, or drop .gz from the \
         name of a plain CSV"
    )]
    DamagedGzip { file: String, reason: String },
    #[error(
        "{file}, line {line}: found bytes that are not UTF-8 text, expected a CSV text file; export it as \
         UTF-8 CSV"
    )]
    NotText { file: String, line: u64 },
    #[error(
        "{at}: found columns separated by spaces, expected commas, semicolons or tabs; export it as comma-separated values"
    )]
    Separator { at: String },
    #[error(
        "{target}={column} is mapped, but {file} has no column `{column}`; found {found}{}",
        similar.as_ref().map_or(String::new(), |s| format!("; did you mean `{s}`?"))
    )]
    MappedColumn { file: String, target: String, column: String, found: String, similar: Option<String> },
    #[error("{target}={column} is mapped, but the name or the column is mapped twice; keep one of the two")]
    MappedTwice { target: String, column: String },
    #[error(
        "{target} is mapped, but its unit in {file} is `{found}`, expected one that converts into {expected}; correct \
         the unit, or leave it out"
    )]
    MappedUnit { file: String, target: String, found: String, expected: String },
    #[error(
        "{place}: found `{found}`, expected a decimal comma as in the rest of the file; correct the cell"
    )]
    DecimalSign { place: Place, found: String },
    #[error("{file}: is not a Parquet file that can be read ({reason}); write it again, or as CSV")]
    Parquet { file: String, reason: String },
    #[error(
        "{file}, column `{column}`: is nested ({found}), expected plain columns of numbers; write each part as a column \
         of its own"
    )]
    Nested { file: String, column: String, found: &'static str },
    #[error("{place}: is null, expected a number (only optional columns may have nulls); drop the row")]
    Null { place: Place },
    #[error(
        "{file}: is a Parquet file, and this program was built without the feature `parquet`; write it as CSV"
    )]
    NoParquet { file: String },
    #[error("{file}: is a LabVIEW TDMS file, expected CSV or Parquet; export its channels as one of the two")]
    NoTdms { file: String },
    #[error("{at}: column {number} has no name, expected a name in every field of the header")]
    UnnamedColumn { at: String, number: usize },
    #[error("{at}: column `{column}` stands there twice; keep one of the two or rename the other")]
    DoubledColumn { at: String, column: String },
    #[error("{at}: the name of column {number}, `{column}`, {reason}; rename the column")]
    UnsafeColumn { at: String, number: usize, column: String, reason: UnsafeText },
    #[error("{at}: {}; found {found}; {}", absent(missing), mend(missing))]
    MissingColumns {
        at: String,
        /// The missing columns, and for each the name in the file that is nearly it.
        missing: Vec<(String, Option<String>)>,
        found: String,
    },
    #[error(
        "{at}: found both `{pair}` and `{direct}`, expected the columns of one sensor: `x1_mm`, \
         `x2_mm`, `reference_arcsec`, or `measured`, `reference`; drop one group"
    )]
    TwoSensors { at: String, pair: String, direct: String },
    #[error(
        "{file}, line {line}: found {found} fields, expected {expected} as in the header; mend the row (a \
         comma as decimal sign, or a row cut short?)"
    )]
    FieldCount { file: String, line: u64, found: usize, expected: usize },
    #[error("{place}: found `{found}`, expected a number; correct the cell or drop the row")]
    NotANumber { place: Place, found: String },
    #[error(
        "{place}: found `{found}`, expected a finite number; drop the row, or leave the cell of an optional \
         column blank where nothing was measured"
    )]
    NotFinite { place: Place, found: String },
    #[error("{place}: is blank, expected a number (only optional columns may have blanks); drop the row")]
    Blank { place: Place },
    #[error(
        "{place}: found `{found}`, expected a whole number (0, 1, 2 …), one for all rows that belong together; number \
         them"
    )]
    NotWhole { place: Place, found: String },
    #[error(
        "{place}: found `{found}`, expected 1 (forward) or -1 (backward), or throughout 1 and 0; correct the direction"
    )]
    Direction { place: Place, found: String },
}
