//! Reading a table from text (CSV), every cell that is used checked, without an allocation per row.

use std::io::Read;

use csv::{ByteRecord, ErrorKind};

use super::columns::{Cell, Columns, Uses};
use super::{Dialect, Naming, RecordingError, Table};
use crate::input;

/// Room of a buffer.
pub(super) const BUFFER: usize = 1 << 20;
/// So much of the beginning tells the dialect, and whether the file is a recording at all.
const HEAD: u64 = 1 << 16;

/// Reads a table; its hash is left blank. Blank lines and comments, which begin with `#`, are skipped.
pub(super) fn read(
    file: &str,
    mut text: impl Read,
    compressed: bool,
    naming: &Naming,
    uses: &Uses,
) -> Result<Table, RecordingError> {
    let failed = |error: std::io::Error| RecordingError::of(file, &error, compressed);
    let broken = |error: csv::Error| match error.kind() {
        ErrorKind::Io(error) => RecordingError::of(file, error, compressed),
        _ => failed(error.into()),
    };
    let mut head = Vec::new();
    text.by_ref().take(HEAD).read_to_end(&mut head).map_err(failed)?;
    input::expect(file, &head, input::Kind::Recording)?;
    let dialect = Dialect::of(&head);
    // Lines end in a line feed, also the last; a carriage return before it is trimmed with the blanks around a field.
    let mut reader = csv::ReaderBuilder::new()
        .terminator(csv::Terminator::Any(b'\n'))
        .delimiter(dialect.delimiter)
        .comment(Some(b'#'))
        .has_headers(false)
        .flexible(true)
        .buffer_capacity(BUFFER)
        .from_reader(head.as_slice().chain(text).chain(&b"\n"[..]));
    let mut row = ByteRecord::new();
    let blank = |row: &ByteRecord| row.len() == 1 && row[0].trim_ascii().is_empty();
    let mut columns: Option<Columns> = None;
    while reader.read_byte_record(&mut row).map_err(broken)? {
        if blank(&row) {
            continue;
        }
        // The reader has gone on to the line after the record.
        let line = reader.position().line() - 1;
        let Some(columns) = &mut columns else {
            let not_text = |_| RecordingError::NotText { file: file.to_string(), line };
            let name = |field| std::str::from_utf8(field).map(|name| name.trim().to_string());
            let names = row.iter().map(name).collect::<Result<Vec<_>, _>>().map_err(not_text)?;
            let at = (file.to_string(), Some(line));
            columns = Some(Columns::new(file, at, names, naming, uses)?);
            continue;
        };
        let (found, expected) = (row.len(), columns.count());
        if found != expected {
            return Err(RecordingError::FieldCount { file: file.to_string(), line, found, expected });
        }
        for (index, field) in row.iter().enumerate() {
            if !columns.reads(index) {
                continue;
            }
            let field = field.trim_ascii();
            match cell(field, dialect) {
                // A number whose point is no decimal sign in this file: left as text it would vanish.
                Cell::Text(text) if dialect.decimal_comma && parse(text).is_some() => {
                    return Err(columns.decimal_sign(line, index, text));
                }
                cell => columns.cell(line, index, cell, || String::from_utf8_lossy(field).into_owned())?,
            }
        }
        columns.row(line);
    }
    match columns {
        Some(columns) => columns.finish(dialect),
        None => Err(RecordingError::Empty { file: file.to_string() }),
    }
}

/// What a field holds. "nan" and "inf" are numbers here and refused later.
fn cell(field: &[u8], dialect: Dialect) -> Cell<'_> {
    if field.is_empty() {
        return Cell::Blank;
    }
    let mut room = [0; 64];
    let number =
        if dialect.decimal_comma { dialect.plain(field, &mut room).and_then(parse) } else { parse(field) };
    number.map_or(Cell::Text(field), Cell::Number)
}

/// The field as a number, `None` if it is not one.
fn parse(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}
