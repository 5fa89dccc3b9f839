//! What is noticed while a recording is read.

use crate::table::Dialect;

/// Something that was noticed while reading and does not forbid a fit.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // what the variants say of them
pub enum Note {
    /// Time runs backward at `line`, from `from_s` to `to_s`.
    TimeBackward { line: u64, from_s: f64, to_s: f64 },
    /// A column that holds no numbers was left out.
    TextColumn { column: String },
    /// The file separates its columns, or writes its numbers, in another way than by commas and points.
    Dialect(Dialect),
    /// Columns were taken under other names, or converted.
    Mapped { columns: Vec<String> },
    /// No row has a pass number that lies between those of others.
    EmptyPass { pass: i64, first: i64, last: i64 },
    /// Points in time, or a count since 1970, stand for seconds; `from` is the first as it stands in a file.
    Timestamps { column: String, from: Option<String> },
    /// A column that a fit needs is not there and something else stands for it.
    Assumed { column: &'static str, taken: &'static str },
}

impl Note {
    /// That times are seconds since the first, which stands in the file so.
    pub fn since(first: String) -> Note {
        Note::Timestamps { column: "t_s".into(), from: Some(first) }
    }
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
            Note::Timestamps { column, from } => {
                write!(f, "column `{column}` holds timestamps: taken as seconds since its first row")?;
                from.iter().try_for_each(|from| write!(f, ", {from}"))
            }
            Note::Assumed { column, taken } => write!(f, "column `{column}` is missing: {taken}"),
        }
    }
}
