//! A table that another program holds in memory: columns by name, not row by row.

use sha2::{Digest, Sha256};

use super::columns::{Cell, Columns, Uses};
use super::{Column, Dialect, Naming, RecordingError, Table, Values, counts_rows};
use crate::text_safety;

/// The cells of a column.
#[derive(Debug, Clone)]
pub enum Cells {
    /// A number in every row, NaN where there is none; taken without a copy, unless a mapping converts them.
    Numbers(Values),
    /// Numbers and nulls.
    Nullable(Vec<Option<f64>>),
    /// Text and nulls.
    Texts(Vec<Option<String>>),
    /// What is no plain column, in words: it is refused, as in a file.
    Nested {
        /// Number of rows.
        rows: usize,
        /// What it is.
        found: &'static str,
    },
}

impl Cells {
    fn rows(&self) -> usize {
        match self {
            Cells::Numbers(values) => values.len(),
            Cells::Nullable(values) => values.len(),
            Cells::Texts(values) => values.len(),
            Cells::Nested { rows, .. } => *rows,
        }
    }
}

impl Table {
    /// Takes columns in memory for a file. `file` is the name that stands in messages and provenance: rows are counted
    /// from 1 under the names [`IN_MEMORY`](super::IN_MEMORY) and `….parquet`, else they have the lines of a CSV file. In
    /// the place of the hash of a file stands that of names and numbers.
    ///
    /// # Errors
    /// As [`Table::read`], and [`RecordingError::Lengths`].
    pub fn of_columns(
        file: &str,
        given: Vec<(String, Cells)>,
        naming: &Naming,
        uses: &Uses,
    ) -> Result<Table, RecordingError> {
        check(file, &given)?;
        let rows = given.first().map_or(0, |(_, cells)| cells.rows());
        let first = if counts_rows(file) { 1 } else { 2 };
        let names = given.iter().map(|(name, _)| name.clone()).collect();
        let mut columns = Columns::new(file, (file.to_string(), None), names, naming, uses)?;
        for (index, (_, cells)) in given.into_iter().enumerate() {
            if columns.reads(index) {
                take(&mut columns, index, first, cells)?;
            }
        }
        (first..).take(rows).for_each(|line| columns.row(line));
        let table = columns.finish(Dialect::PLAIN)?;
        Ok(Table { sha256: hash(&table.columns), ..table })
    }
}

/// Refuses columns that are nested, or of several lengths.
fn check(file: &str, given: &[(String, Cells)]) -> Result<(), RecordingError> {
    for (name, cells) in given {
        let column = || text_safety::excerpt(name, 40);
        if let Cells::Nested { found, .. } = cells {
            return Err(RecordingError::Nested { file: file.to_string(), column: column(), found });
        }
        let (first, expected) = (&given[0].0, given[0].1.rows());
        if cells.rows() != expected {
            let (found, first) = (cells.rows(), text_safety::excerpt(first, 40));
            return Err(RecordingError::Lengths {
                file: file.to_string(),
                column: column(),
                found,
                first,
                expected,
            });
        }
    }
    Ok(())
}

/// Takes the cells of a column, the first of which stands on line `first`.
fn take(columns: &mut Columns, index: usize, first: u64, cells: Cells) -> Result<(), RecordingError> {
    match cells {
        Cells::Numbers(values) => columns.numbers(first, index, values),
        Cells::Nullable(values) => {
            for (line, value) in (first..).zip(values) {
                let cell = value.map_or(Cell::Null, Cell::Number);
                columns.cell(line, index, cell, || value.unwrap_or(f64::NAN).to_string())?;
            }
            Ok(())
        }
        Cells::Texts(values) => {
            for (line, value) in (first..).zip(values) {
                let text = value.as_ref().map(|text| text.trim().as_bytes());
                let cell = match text {
                    None => Cell::Null,
                    Some(b"") => Cell::Blank,
                    Some(text) => Cell::Text(text),
                };
                columns.cell(line, index, cell, || value.clone().unwrap_or_default())?;
            }
            Ok(())
        }
        // Refused before.
        Cells::Nested { .. } => Ok(()),
    }
}

/// The SHA-256 of names and numbers: the same whoever holds them.
fn hash(columns: &[Column]) -> String {
    let mut hash = Sha256::new();
    for column in columns {
        hash.update(column.name.as_bytes());
        hash.update([0]);
        let mut bytes = Vec::with_capacity(8 << 12);
        for chunk in column.values.chunks(1 << 12) {
            bytes.clear();
            // There are many NaN, and only one of them is hashed.
            let one = |value: &f64| if value.is_nan() { f64::NAN } else { *value };
            bytes.extend(chunk.iter().flat_map(|value| one(value).to_le_bytes()));
            hash.update(&bytes);
        }
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::table::{Header, IN_MEMORY, Use};

    fn numbers(values: &[f64]) -> Cells {
        Cells::Numbers(values.to_vec().into())
    }

    fn table(file: &str, columns: Vec<(&str, Cells)>) -> Result<Table, RecordingError> {
        let uses = |header: &Header| {
            header.require(&["a"])?;
            Ok(header
                .names
                .iter()
                .map(|name| if name == "a" { Use::Needed } else { Use::Optional })
                .collect())
        };
        let columns = columns.into_iter().map(|(name, cells)| (name.to_string(), cells)).collect();
        Table::of_columns(file, columns, &Naming::default(), &uses)
    }

    fn refused(columns: Vec<(&str, Cells)>) -> String {
        table(IN_MEMORY, columns).unwrap_err().to_string()
    }

    #[test]
    fn lent_numbers_are_not_copied() {
        let lent = Arc::new(vec![1.0, 2.0, 3.0]);
        let mut read = table(IN_MEMORY, vec![("a", Cells::Numbers(Values::lent(lent.clone())))]).unwrap();
        assert_eq!(read.rows, 3);
        assert_eq!(read.take("a").unwrap().as_ptr(), lent.as_ptr());
    }

    #[test]
    fn rows_are_named_as_in_a_file_of_that_name() {
        let wrong = || vec![("a", numbers(&[0.0, f64::NAN]))];
        let message = |file| table(file, wrong()).unwrap_err().to_string();
        assert!(
            message(IN_MEMORY).starts_with("table, row 2, column `a`: found `NaN`, expected a finite number")
        );
        assert!(message("held-out table").starts_with("held-out table, row 2, column `a`"));
        assert!(message("x.parquet").starts_with("x.parquet, row 2, column `a`"));
        assert!(message("x.csv").starts_with("x.csv, line 3, column `a`"));
    }

    #[test]
    fn an_optional_column_may_have_blanks() {
        let text = Cells::Texts(vec![Some("x".into()), None]);
        let read = table(
            IN_MEMORY,
            vec![
                ("a", numbers(&[1.0, 2.0])),
                ("b", numbers(&[f64::NAN, 2.0])),
                ("c", Cells::Nullable(vec![None, Some(3.0)])),
                ("d", text),
            ],
        )
        .unwrap();
        let first: Vec<bool> = read.columns.iter().map(|column| column.values[0].is_nan()).collect();
        assert_eq!(first, [false, true, true]);
        assert_eq!(read.without_numbers, ["d"]);
    }

    #[test]
    fn what_cannot_be_read_is_refused_as_in_a_file() {
        let null = refused(vec![("a", Cells::Nullable(vec![Some(1.0), None]))]);
        assert!(null.starts_with("table, row 2, column `a`: is null, expected a number"), "{null}");
        let text = refused(vec![("a", Cells::Texts(vec![Some("off".into())]))]);
        assert!(text.starts_with("table, row 1, column `a`: found `off`, expected a number"), "{text}");
        let nested = refused(vec![("a", Cells::Nested { rows: 1, found: "a list" })]);
        assert!(nested.starts_with("table, column `a`: is nested (a list)"), "{nested}");
        let lengths = refused(vec![("a", numbers(&[1.0, 2.0])), ("b", numbers(&[1.0]))]);
        assert!(
            lengths.starts_with("table, column `b`: found 1 values, expected 2 as in column `a`"),
            "{lengths}"
        );
        assert!(refused(vec![("A", numbers(&[1.0]))]).contains("column `a` is missing"));
        assert!(refused(vec![("a", numbers(&[]))]).contains("has a header but no reading"));
        assert!(refused(Vec::new()).contains("column `a` is missing"));
    }
}
