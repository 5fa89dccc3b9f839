//! From cells, row by row, to columns: the same for every kind of file.

use super::mapping::Conversion;
use super::timestamp::Timestamp;
use super::{Column, Dialect, Header, Lines, Naming, RecordingError, Table, Use, Values};
use crate::input;
use crate::message::FileLine;
use crate::text_safety;

/// What stands in a cell.
#[derive(Debug, Clone, Copy)]
pub enum Cell<'a> {
    /// Nothing.
    Blank,
    /// A null of a file that knows them.
    Null,
    /// A number.
    Number(f64),
    /// What is no number, as it stands there.
    Text(&'a [u8]),
}

/// Says of every column of a header how it is used.
pub type Uses<'a> = dyn Fn(&Header) -> Result<Vec<Use>, RecordingError> + 'a;

/// A column that is being read.
struct Reading {
    used: Use,
    conversion: Option<Conversion>,
    values: Vec<f64>,
    /// All of them, where they lie in memory.
    lent: Option<Values>,
    /// What its first cell that is not blank says; a column of text holds no values.
    is_text: Option<bool>,
    /// Of points in time: the first, in whole seconds and as it stands there.
    start: Option<(i64, String)>,
}

impl Reading {
    /// Takes a point in time as seconds since the first, and gives back the decimals of its seconds; none where the column
    /// holds numbers, or the text is none.
    fn take_time(&mut self, text: &[u8]) -> Option<i32> {
        let time = Timestamp::parse(text)?;
        if self.start.is_none() && self.values.is_empty() {
            self.start = Some((time.seconds, text_safety::cell(text)));
        }
        let start = self.start.as_ref()?.0;
        self.values.push(time.since(start));
        Some(time.decimals)
    }
}

/// A table that is being read.
pub struct Columns {
    header: Header,
    columns: Vec<Reading>,
    lines: Lines,
    rows: usize,
    decimals: i32,
    rounding_factor: f64,
}

impl Columns {
    /// Understands a header whose names in the file are `names` and which stands at `at`.
    ///
    /// # Errors
    /// [`RecordingError`] of too many columns, of names, and those of `uses`.
    pub fn new(
        file: &str,
        at: FileLine,
        names: Vec<String>,
        naming: &Naming,
        uses: &Uses,
    ) -> Result<Columns, RecordingError> {
        input::check_columns(names.len())
            .map_err(|limit| input::FileError::Limit { file: file.to_string(), limit })?;
        let (renamed, conversions) = naming.rename(file, &names)?;
        let header = Header { file: file.to_string(), at, names: renamed, in_file: names };
        header.check()?;
        let uses = uses(&header)?;
        let printed = uses.iter().position(|used| *used == Use::Printed).and_then(|at| conversions[at]);
        let column = |(used, conversion)| Reading {
            used,
            conversion,
            values: Vec::new(),
            lent: None,
            is_text: None,
            start: None,
        };
        let columns = uses.into_iter().zip(conversions).map(column).collect();
        let rounding_factor = printed.map_or(1.0, |conversion| conversion.factor.abs());
        Ok(Columns { header, columns, lines: Lines::default(), rows: 0, decimals: 0, rounding_factor })
    }

    /// Number of columns of a row.
    pub(super) fn count(&self) -> usize {
        self.columns.len()
    }

    /// Whether the cells of a column are looked at.
    pub fn reads(&self, index: usize) -> bool {
        let column = &self.columns[index];
        column.used != Use::Ignored && column.is_text != Some(true)
    }

    /// Takes the cell of column `index` on `line`; `text` is how it is printed.
    ///
    /// # Errors
    /// [`RecordingError`] of a cell that does not hold what its column needs.
    pub fn cell(
        &mut self,
        line: u64,
        index: usize,
        cell: Cell,
        text: impl FnOnce() -> String,
    ) -> Result<(), RecordingError> {
        if let Some(value) = self.checked(line, index, cell, text)? {
            self.columns[index].values.push(value);
        }
        Ok(())
    }

    /// Takes a column of numbers that lie in memory, the first of which stands on line `first`. They are copied only where
    /// they are converted.
    pub(super) fn numbers(
        &mut self,
        first: u64,
        index: usize,
        numbers: Values,
    ) -> Result<(), RecordingError> {
        let blank = self.columns[index].used == Use::Optional;
        let converted = self.columns[index].conversion.is_some();
        for (line, value) in (first..).zip(&numbers) {
            let cell = if blank && value.is_nan() { Cell::Blank } else { Cell::Number(*value) };
            let value = self.checked(line, index, cell, || value.to_string())?;
            self.columns[index].values.extend(value.filter(|_| converted));
        }
        self.columns[index].lent = Some(numbers).filter(|_| !converted);
        Ok(())
    }

    /// The value of a cell in the unit that is expected; none in a column of text.
    fn checked(
        &mut self,
        line: u64,
        index: usize,
        cell: Cell,
        text: impl FnOnce() -> String,
    ) -> Result<Option<f64>, RecordingError> {
        let column = &mut self.columns[index];
        if column.used == Use::Optional {
            if column.is_text.is_none() && !matches!(cell, Cell::Blank | Cell::Null) {
                column.is_text = Some(matches!(cell, Cell::Text(_)));
            }
            if column.is_text == Some(true) {
                return Ok(None);
            }
        }
        if let (Use::Time | Use::Printed, Cell::Text(text)) = (column.used, &cell)
            && let Some(decimals) = column.take_time(text)
        {
            self.decimals = self.decimals.max(decimals);
            return Ok(None);
        }
        let (used, is_number) = (column.used, column.start.is_none());
        let place = || self.header.place(line, &self.header.names[index]);
        let value = match cell {
            Cell::Number(value) if value.is_finite() && is_number => value,
            Cell::Number(value) if !is_number => {
                return Err(RecordingError::NoTime { place: place(), found: value.to_string() });
            }
            Cell::Number(value) => {
                return Err(RecordingError::NotFinite { place: place(), found: value.to_string() });
            }
            Cell::Blank | Cell::Null if used == Use::Optional => f64::NAN,
            Cell::Blank => return Err(RecordingError::Blank { place: place() }),
            Cell::Null => return Err(RecordingError::Null { place: place() }),
            Cell::Text(text) => word(used, text).ok_or_else(|| RecordingError::NotANumber {
                place: place(),
                found: text_safety::cell(text),
            })?,
        };
        if used == Use::Whole && (value.fract() != 0.0 || value.abs() > 1e9) {
            return Err(RecordingError::NotWhole { place: place(), found: value.to_string() });
        }
        if used == Use::Printed {
            self.decimals = self.decimals.max(printed_decimals(&text()));
        }
        Ok(Some(match self.columns[index].conversion {
            Some(Conversion { factor, offset }) => factor * value + offset,
            None => value,
        }))
    }

    /// A row ends, which stands on `line`.
    pub fn row(&mut self, line: u64) {
        self.lines.push(self.rows, line);
        self.rows += 1;
    }

    /// The refusal of a cell whose number has a point where the file has a decimal comma.
    pub(super) fn decimal_sign(&self, line: u64, index: usize, text: &[u8]) -> RecordingError {
        let place = self.header.place(line, &self.header.names[index]);
        RecordingError::DecimalSign { place, found: text_safety::cell(text) }
    }

    /// The table, once all rows are in. Its hash is blank.
    ///
    /// # Errors
    /// [`RecordingError::NoRows`].
    pub fn finish(self, dialect: Dialect) -> Result<Table, RecordingError> {
        let Columns { header, columns, lines, rows, decimals, rounding_factor } = self;
        if rows == 0 {
            return Err(RecordingError::NoRows { file: header.file });
        }
        let started = columns.iter().find_map(|column| column.start.as_ref().map(|(_, text)| text.clone()));
        let (mut kept, mut without_numbers) = (Vec::new(), Vec::new());
        for (name, column) in header.names.iter().zip(columns) {
            match (column.used, column.is_text) {
                (Use::Ignored, _) => {}
                (Use::Optional, None | Some(true)) => without_numbers.push(name.clone()),
                _ => {
                    let values = column.lent.unwrap_or_else(|| column.values.into());
                    kept.push(Column { name: name.clone(), values });
                }
            }
        }
        let rounding = rounding_factor * 10f64.powi(-decimals);
        let (file, sha256) = (header.file.clone(), String::new());
        Ok(Table {
            file,
            sha256,
            rows,
            header,
            columns: kept,
            without_numbers,
            rounding,
            started,
            dialect,
            lines,
        })
    }
}

/// The number that a word stands for, where the column knows any.
fn word(used: Use, text: &[u8]) -> Option<f64> {
    let Use::Words(words) = used else { return None };
    words.iter().find(|(word, _)| text.eq_ignore_ascii_case(word.as_bytes())).map(|(_, value)| *value)
}

/// Power of ten of the last printed digit, negated: 4 of `0.0005`, 7 of `5e-7`.
fn printed_decimals(text: &str) -> i32 {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().unwrap_or(0)),
        None => (text, 0),
    };
    let digits = mantissa.split_once(['.', ',']).map_or(0, |(_, digits)| digits.len() as i32);
    digits.saturating_sub(exponent)
}
