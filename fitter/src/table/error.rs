//! What can be wrong with a recording before anything is computed from it: one message each, which says
//! where, what was found, what was expected and how to mend it.

use crate::input::{FileError, LimitError};
use crate::message::{FileLine, Message, Where};
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
        Message::default().at(self).fmt(f)
    }
}

impl Where for Place {
    fn enter(&self, message: Message) -> Message {
        message.line(self.line).column(&self.column).at(&self.file)
    }
}

impl RecordingError {
    /// Of a reading that ended early: at a limit, or for what the system, or the decompression, says.
    pub fn of(file: &str, error: &std::io::Error, compressed: bool) -> RecordingError {
        let (file, reason) = (file.to_string(), error.to_string());
        match LimitError::of(error) {
            Some(limit) => FileError::Limit { file, limit }.into(),
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

errors! {
    /// Why a recording is refused.
    #[derive(Debug)]
    pub enum RecordingError {
        NotFound { file: String } =>
            at(file) says("there is no such file") mend("check the path of the recording");
        IsDirectory { file: String } =>
            at(file) says("is a directory") expected("a recording (CSV, CSV.gz or Parquet)")
            mend("name the file itself");
        Unreadable { file: String, reason: String } =>
            at(file) says("cannot be read ({reason})") mend("check the file's permissions and medium");
        Empty { file: String } =>
            at(file) says("is empty") expected("a header row and one row per reading")
            mend("record or export it again");
        NoRows { file: String } =>
            at(file) says("has a header but no reading") expected("one row per reading")
            mend("export the rows as well");
        DamagedGzip { file: String, reason: String } =>
            at(file) says("ends in .gz but is not a whole gzip file ({reason})")
            mend("copy it again, or drop .gz from the name of a plain CSV");
        NotText { file: String, line: u64 } =>
            at(file) line(line) found("bytes that are not UTF-8 text") expected("a CSV text file")
            mend("export it as UTF-8 CSV");
        Separator { at: FileLine } =>
            at(at) found("columns separated by spaces") expected("commas, semicolons or tabs")
            mend("export it as comma-separated values");
        MappedColumn { file: String, mapping: String, found: String, similar: Option<String> } =>
            at(file) says("{mapping} is mapped, but there is no such column")
            found("{found}")
            mend("{}", similar.as_ref().map_or("map one of these".into(), |name| format!("did you mean `{name}`?")))
            by(map);
        MappedTwice { target: String, column: String } =>
            says("{target}={column} is mapped, but the name or the column is mapped twice")
            mend("keep one of the two") by(map);
        MappedUnit { file: String, target: String, found: String, expected: String } =>
            at(file) says("{target} is mapped, but its unit is `{found}`")
            expected("one that converts into {expected}") mend("correct the unit, or leave it out") by(map);
        DecimalSign { place: Place, found: String } =>
            at(place) cell("{found}") expected("a decimal comma as in the rest of the file")
            mend("correct the cell");
        Parquet { file: String, reason: String } =>
            at(file) says("is not a Parquet file that can be read ({reason})")
            mend("write it again, or as CSV");
        Nested { file: String, column: String, found: &'static str } =>
            at(file) column(column) says("is nested ({found})") expected("plain columns of numbers")
            mend("write each part as a column of its own");
        Lengths { file: String, column: String, found: usize, first: String, expected: usize } =>
            at(file) column(column) found("{found} values") expected("{expected} as in column `{first}`")
            mend("give every column one value for each row");
        Null { place: Place } =>
            at(place) says("is null") expected("a number (only optional columns may have nulls)")
            mend("drop the row");
        NoParquet { file: String } =>
            at(file) says("is a Parquet file, which this program does not read")
            mend("write it as CSV, or give it to `arcsmith`");
        NoTdms { file: String } =>
            at(file) says("is a LabVIEW TDMS file") expected("CSV or Parquet")
            mend("export its channels as one of the two");
        UnnamedColumn { at: FileLine, number: usize } =>
            at(at) says("column {number} has no name") expected("a name in every field of the header");
        DoubledColumn { at: FileLine, column: String } =>
            at(at) says("column `{column}` stands there twice")
            mend("keep one of the two or rename the other");
        UnsafeColumn { at: FileLine, number: usize, column: String, reason: UnsafeText } =>
            at(at) says("the name of column {number}, `{column}`, {reason}") mend("rename the column");
        /// The missing columns, and for each the name in the file that is nearly it.
        MissingColumns { at: FileLine, missing: Vec<(String, Option<String>)>, found: String } =>
            at(at) says("{}", absent(missing)) found("{found}") mend("{}", mend(missing)) by(map);
        TwoSensors { at: FileLine, pair: String, direct: String } =>
            at(at) found("both `{pair}` and `{direct}`")
            expected("the columns of one sensor: `x1_mm`, `x2_mm`, `reference_arcsec`, or `measured`, \
                `reference`")
            mend("drop one group");
        FieldCount { file: String, line: u64, found: usize, expected: usize } =>
            at(file) line(line) found("{found} fields") expected("{expected} as in the header")
            mend("mend the row (a comma as decimal sign, or a row cut short?)");
        NotANumber { place: Place, found: String } =>
            at(place) cell("{found}") expected("a number") mend("correct the cell or drop the row");
        NoTime { place: Place, found: String } =>
            at(place) cell("{found}") expected("a point in time as in the rows above")
            mend("correct the cell or drop the row");
        NotFinite { place: Place, found: String } =>
            at(place) cell("{found}") expected("a finite number")
            mend("drop the row, or leave the cell of an optional column blank where nothing was measured");
        Blank { place: Place } =>
            at(place) says("is blank") expected("a number (only optional columns may have blanks)")
            mend("drop the row");
        NotWhole { place: Place, found: String } =>
            at(place) cell("{found}")
            expected("a whole number (0, 1, 2 …), one for all rows that belong together") mend("number them");
        Direction { place: Place, found: String } =>
            at(place) cell("{found}") expected("1 (forward) or -1 (backward), or throughout 1 and 0")
            mend("correct the direction");
        TooManyFaults { place: Place, found: String, affected: usize, rows: usize } =>
            at(place)
            found("{found}, and {affected} of {rows} rows like it") expected("at most a tenth")
            mend("correct or drop these rows, or check the column's unit");
    }
    from { File(FileError) }
}
