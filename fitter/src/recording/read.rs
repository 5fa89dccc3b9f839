//! Reading a recording from text (CSV, or CSV.gz), every cell checked, without an allocation per row.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use csv::{ByteRecord, ErrorKind};
use sha2::{Digest, Sha256};

use super::build::{Builder, Cell};
use super::dialect::Dialect;
use super::header::Header;
use super::mapping::{self, Mapping};
use super::{Note, Recording, RecordingError};
use crate::error_model::Sensor;
use crate::input;
use crate::text_safety;

/// What a recording is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To fit: time, pass, direction, readings and reference are needed.
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

impl Reading<'_> {
    /// Columns as the recording format names them.
    pub const fn plain(purpose: Purpose) -> Reading<'static> {
        Reading { purpose, mappings: &[], sensor: None }
    }

    /// Understands a header; `names` are those in the file.
    pub(super) fn builder<'f>(
        &self,
        file: &'f str,
        names: Vec<String>,
    ) -> Result<Builder<'f>, RecordingError> {
        input::check_columns(names.len())
            .map_err(|limit| RecordingError::Limit { file: file.to_string(), limit })?;
        let shown = names.clone();
        let mut names = names;
        let conversions = mapping::rename(file, &mut names, self.mappings, self.sensor)?;
        let header = Header::parse(file, names, self.purpose)?;
        Ok(Builder::new(file, header, conversions, shown))
    }

    /// What is to be said of the mappings.
    pub(super) fn notes(&self) -> Vec<Note> {
        let columns: Vec<String> = self.mappings.iter().map(Mapping::to_string).collect();
        if columns.is_empty() { Vec::new() } else { vec![Note::Mapped { columns }] }
    }
}

impl Recording {
    /// Reads the recording at `path` for a fit; a name that ends in `.gz` is decompressed.
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

    /// As [`Recording::read_for`], with columns mapped and converted. Parquet, and TDMS to refuse it, are known by their first bytes.
    ///
    /// # Errors
    /// As [`Recording::read`], and those of a mapping that does not fit.
    pub fn read_as(
        path: &Path,
        reading: &Reading,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Recording, RecordingError> {
        let shown = text_safety::path(path);
        let name = text_safety::file_name(path);
        let unreadable = |error: std::io::Error| RecordingError::of(&shown, &error, false);
        let mut file = File::open(path).map_err(unreadable)?;
        if file.metadata().map_err(unreadable)?.is_dir() {
            return Err(RecordingError::IsDirectory { file: shown });
        }
        let mut magic = [0; 4];
        let count = read_most(&mut file, &mut magic).map_err(unreadable)?;
        let head = &magic[..count];
        // A pipe cannot be read again from its beginning: what was read is put before the rest.
        let mut recording = match head {
            b"PAR1" => {
                let file = if file.rewind().is_ok() { Ok(file) } else { spooled(head.chain(file)) };
                read_parquet(&shown, file.map_err(unreadable)?, reading, progress)?
            }
            b"TDSm" => return Err(RecordingError::NoTdms { file: shown }),
            _ => read_from(&shown, head.chain(file), input::is_gzip(&shown, head), reading, progress)?,
        };
        recording.file = name;
        Ok(recording)
    }

    /// Reads a recording from bytes; `file` is the name that stands in messages and provenance, and a name
    /// that ends in `.gz` is decompressed.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Recording, RecordingError> {
        let gzip = input::is_gzip(file, bytes);
        read_from(file, bytes, gzip, &Reading::plain(Purpose::Fit), &mut |_| {})
    }
}

/// Hashes and counts what passes through.
struct Hashing<'a, R> {
    inner: R,
    hash: Sha256,
    bytes: u64,
    progress: &'a mut dyn FnMut(u64),
}

impl<R: Read> Read for Hashing<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.hash.update(&buffer[..count]);
        self.bytes += count as u64;
        (self.progress)(self.bytes);
        Ok(count)
    }
}

const BUFFER: usize = 1 << 20;
/// So much of the beginning tells the dialect.
const HEAD: u64 = 1 << 16;

fn read_from<R: Read>(
    file: &str,
    source: R,
    gzip: bool,
    reading: &Reading,
    progress: &mut dyn FnMut(u64),
) -> Result<Recording, RecordingError> {
    let hashing = Hashing { inner: source, hash: Sha256::new(), bytes: 0, progress };
    let mut raw = BufReader::with_capacity(BUFFER, hashing);
    let mut recording = read_text(file, input::text(&mut raw, gzip), reading, gzip)?;
    // What stands behind the last member of a gzip file belongs to the file's bytes as well.
    std::io::copy(&mut raw, &mut std::io::sink()).map_err(|error| RecordingError::of(file, &error, false))?;
    recording.sha256 = hexadecimal(raw.into_inner().hash);
    Ok(recording)
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads until the buffer is full or the source ends; the number of bytes.
fn read_most(source: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut count = 0;
    while count < buffer.len() {
        match source.read(&mut buffer[count..])? {
            0 => break,
            more => count += more,
        }
    }
    Ok(count)
}

/// A file that can be read in any order, of what perhaps cannot.
fn spooled(mut source: impl Read) -> std::io::Result<File> {
    let mut file = tempfile::tempfile()?;
    let most = input::max_bytes();
    if std::io::copy(&mut source.by_ref().take(most.saturating_add(1)), &mut file)? > most {
        let limit = input::LimitError::Bytes { most, decompressed: false };
        return Err(std::io::Error::other(limit));
    }
    file.rewind()?;
    Ok(file)
}

/// Hashes a Parquet file and reads it.
fn read_parquet(
    file: &str,
    mut source: File,
    reading: &Reading,
    progress: &mut dyn FnMut(u64),
) -> Result<Recording, RecordingError> {
    let unreadable = |error: std::io::Error| RecordingError::of(file, &error, false);
    let mut hashing = Hashing { inner: &mut source, hash: Sha256::new(), bytes: 0, progress };
    std::io::copy(&mut hashing, &mut std::io::sink()).map_err(unreadable)?;
    let sha256 = hexadecimal(hashing.hash);
    source.rewind().map_err(unreadable)?;
    Ok(Recording { sha256, ..parquet(file, source, reading)? })
}

#[cfg(feature = "parquet")]
use super::parquet::read as parquet;

#[cfg(not(feature = "parquet"))]
fn parquet(file: &str, _: File, _: &Reading) -> Result<Recording, RecordingError> {
    Err(RecordingError::NoParquet { file: file.to_string() })
}

fn read_text<R: Read>(
    file: &str,
    mut text: R,
    reading: &Reading,
    compressed: bool,
) -> Result<Recording, RecordingError> {
    let failed = |error: std::io::Error| RecordingError::of(file, &error, compressed);
    let broken = |error: csv::Error| match error.kind() {
        ErrorKind::Utf8 { pos, .. } => {
            RecordingError::NotText { file: file.to_string(), line: pos.as_ref().map_or(1, |pos| pos.line()) }
        }
        ErrorKind::Io(error) => RecordingError::of(file, error, compressed),
        _ => failed(error.into()),
    };
    let mut head = Vec::new();
    text.by_ref().take(HEAD).read_to_end(&mut head).map_err(failed)?;
    let dialect = Dialect::of(&head);
    // Lines end in a line feed; a carriage return before it is trimmed with the blanks around a field.
    let mut reader = csv::ReaderBuilder::new()
        .terminator(csv::Terminator::Any(b'\n'))
        .delimiter(dialect.delimiter)
        .has_headers(false)
        .flexible(true)
        .buffer_capacity(BUFFER)
        .from_reader(head.as_slice().chain(text));
    let mut row = ByteRecord::new();
    if !reader.read_byte_record(&mut row).map_err(broken)? {
        return Err(RecordingError::Empty { file: file.to_string() });
    }
    let names = row
        .iter()
        .map(|field| std::str::from_utf8(field).map(|name| name.trim().to_string()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|_| RecordingError::NotText { file: file.to_string(), line: 1 })?;
    let mut builder = reading.builder(file, names)?;
    while reader.read_byte_record(&mut row).map_err(broken)? {
        // A record begins, for the reader, where the one before ended: blank lines stand in between. It
        // ends in the line before the reader's, or in the reader's if the file ends without a line feed.
        let begun = row.position().map_or(0, |position| position.line());
        let line = begun.max(reader.position().line() - 1);
        if row.len() == 1 && row[0].trim_ascii().is_empty() {
            continue;
        }
        if row.len() != builder.columns() {
            let (found, expected) = (row.len() as u64, builder.columns() as u64);
            return Err(RecordingError::FieldCount { file: file.to_string(), line, found, expected });
        }
        for (index, field) in row.iter().enumerate() {
            let field = field.trim_ascii();
            let cell = match cell(field, dialect) {
                // A number whose point is no decimal sign in this file: left as text it would vanish.
                Cell::Text(text) if dialect.decimal_comma && parse(text).is_some() => {
                    let place = builder.place(line, index);
                    return Err(RecordingError::DecimalSign { place, found: text_safety::cell(text) });
                }
                cell => cell,
            };
            builder.cell(line, index, cell)?;
        }
        builder.row(line);
    }
    let mut notes = reading.notes();
    if dialect != Dialect::PLAIN {
        notes.insert(0, Note::Dialect(dialect));
    }
    builder.finish(reading.purpose, notes)
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
