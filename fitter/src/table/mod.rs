//! A table of numbers as a file holds it: columns by name, out of CSV in its dialects, packed or not, or out of another
//! [`Format`] that a program added; or as another program holds it in memory.
//!
//! This is the one reader of recordings. What a column means is not known here: a kind of recording says of each column
//! of a header how it is used ([`Use`]), and takes what was read.

#[cfg(feature = "fit")]
mod columns;
mod dialect;
#[cfg(feature = "fit")]
mod error;
#[cfg(feature = "fit")]
mod format;
#[cfg(feature = "fit")]
mod header;
mod lines;
#[cfg(feature = "fit")]
mod mapping;
#[cfg(feature = "fit")]
mod memory;
#[cfg(feature = "fit")]
mod source;
#[cfg(feature = "fit")]
mod text;
#[cfg(feature = "fit")]
mod timestamp;
mod values;

#[cfg(feature = "fit")]
pub use columns::{Cell, Columns, Uses};
pub use dialect::Dialect;
#[cfg(feature = "fit")]
pub use error::{Place, RecordingError};
#[cfg(feature = "fit")]
pub use format::{Format, Read, add_format};
#[cfg(feature = "fit")]
pub use header::{Header, family, nearest};
pub(crate) use lines::counts_rows;
pub use lines::{IN_MEMORY, Lines};
#[cfg(feature = "fit")]
pub use mapping::{Mapping, Naming};
#[cfg(feature = "fit")]
pub use memory::Cells;
pub use values::Values;

/// How a column is used.
#[cfg(feature = "fit")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Use {
    /// Not at all.
    Ignored,
    /// Where it holds numbers; cells may be blank.
    Optional,
    /// Every cell is a finite number.
    Needed,
    /// As [`Use::Time`], and how finely the times are printed matters.
    Printed,
    /// Every cell is a number of seconds, or every cell a point in time; those become seconds since the first.
    Time,
    /// Every cell is a whole number, at most 10⁹.
    Whole,
    /// Every cell is a number, or one of these words for it, in lower case.
    Words(&'static [(&'static str, f64)]),
}

/// A column as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name in the header, or that to which it is mapped; it ends in the unit (`temperature_c`, `coil_a`).
    pub name: String,
    /// One value per row, NaN where the cell is blank.
    pub values: Values,
}

/// The columns of a file that are used.
#[cfg(feature = "fit")]
#[derive(Debug)]
pub struct Table {
    /// File name without its folder.
    pub file: String,
    /// SHA-256 of the bytes of the file as it lies on disk (of a `.gz`, the compressed bytes), hexadecimal.
    pub sha256: String,
    /// Number of rows, at least one.
    pub rows: usize,
    /// The names of all columns, those that are not used included.
    pub header: Header,
    /// The columns that are used, in the order of the file.
    pub columns: Vec<Column>,
    /// Optional columns that hold no numbers.
    pub without_numbers: Vec<String>,
    /// How far the numbers of the column of [`Use::Printed`] may be rounded: a unit of the last printed digit.
    pub rounding: f64,
    /// The first point in time, as it stands in the file, where the column of times holds such.
    pub started: Option<String>,
    /// How the file separates columns and writes numbers.
    pub dialect: Dialect,
    /// Where the rows stand in the file.
    pub lines: Lines,
}

#[cfg(feature = "fit")]
impl Table {
    /// The values of a column, which is taken out of the table; none if it is not there.
    pub fn take(&mut self, name: &str) -> Option<Values> {
        let at = self.columns.iter().position(|column| column.name == name)?;
        Some(self.columns.remove(at).values)
    }

    /// The column `t_s`, which is taken out of the table. A count of milliseconds, microseconds or nanoseconds since 1970
    /// becomes seconds since the first, which is in `started` then.
    pub fn take_time(&mut self) -> Values {
        let mut time_s = self.take("t_s").unwrap_or_default();
        let Some(first) = time_s.first().copied() else { return time_s };
        if let Some((unit, name)) = timestamp::counted_unit(first) {
            // Neither is a double finer here.
            self.rounding = unit * self.rounding.max(f64::EPSILON * first);
            time_s.iter_mut().for_each(|value| *value = (*value - first) * unit);
            self.started = Some(format!("{first} {name} since 1970"));
        }
        time_s
    }
}
