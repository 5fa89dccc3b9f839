//! Reading a recording from CSV or CSV.gz, every cell checked, without an allocation per row.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use csv::{ByteRecord, ErrorKind};
use flate2::bufread::MultiGzDecoder;
use sha2::{Digest, Sha256};

use super::checks::{self, Lines, Watch};
use super::header::{Header, Role};
use super::{Column, Note, Place, Readings, Recording, RecordingError};

/// What a recording is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To fit: time, pass, direction, readings and reference are needed.
    Fit,
    /// To correct: time and readings are needed.
    Apply,
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
        let shown = path.display().to_string();
        let name = path.file_name().map_or_else(|| shown.clone(), |name| name.to_string_lossy().into_owned());
        let unreadable = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::NotFound => RecordingError::NotFound { file: shown.clone() },
            _ => RecordingError::Unreadable { file: shown.clone(), reason: error.to_string() },
        };
        let file = File::open(path).map_err(unreadable)?;
        if file.metadata().map_err(unreadable)?.is_dir() {
            return Err(RecordingError::IsDirectory { file: shown });
        }
        let mut recording = read_from(&shown, file, purpose, progress)?;
        recording.file = name;
        Ok(recording)
    }

    /// Reads a recording from bytes; `file` is the name that stands in messages and provenance, and a name
    /// that ends in `.gz` is decompressed.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Recording, RecordingError> {
        read_from(file, bytes, Purpose::Fit, &mut |_| {})
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

fn read_from<R: Read>(
    file: &str,
    source: R,
    purpose: Purpose,
    progress: &mut dyn FnMut(u64),
) -> Result<Recording, RecordingError> {
    let hashing = Hashing { inner: source, hash: Sha256::new(), bytes: 0, progress };
    let mut raw = BufReader::with_capacity(BUFFER, hashing);
    let compressed = file.ends_with(".gz");
    let mut recording = if compressed {
        let text = BufReader::with_capacity(BUFFER, MultiGzDecoder::new(&mut raw));
        read_text(file, text, purpose, compressed)?
    } else {
        read_text(file, &mut raw, purpose, compressed)?
    };
    // What stands behind the last member of a gzip file belongs to the file's bytes as well.
    std::io::copy(&mut raw, &mut std::io::sink())
        .map_err(|error| RecordingError::Unreadable { file: file.to_string(), reason: error.to_string() })?;
    let digest = raw.into_inner().hash.finalize();
    recording.sha256 = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(recording)
}

/// Whether a further column holds numbers; decided by its first cell that is not blank.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    Unknown,
    Numbers,
    Text,
}

fn read_text<R: BufRead>(
    file: &str,
    text: R,
    purpose: Purpose,
    compressed: bool,
) -> Result<Recording, RecordingError> {
    let broken = |error: csv::Error| match error.kind() {
        ErrorKind::Utf8 { pos, .. } => {
            RecordingError::NotText { file: file.to_string(), line: pos.as_ref().map_or(1, |pos| pos.line()) }
        }
        _ if compressed => RecordingError::DamagedGzip { file: file.to_string(), reason: error.to_string() },
        _ => RecordingError::Unreadable { file: file.to_string(), reason: error.to_string() },
    };
    // Lines end in a line feed; a carriage return before it is trimmed with the blanks around a field.
    let mut reader = csv::ReaderBuilder::new()
        .terminator(csv::Terminator::Any(b'\n'))
        .has_headers(false)
        .flexible(true)
        .buffer_capacity(BUFFER)
        .from_reader(text);
    let mut row = ByteRecord::new();
    if !reader.read_byte_record(&mut row).map_err(broken)? {
        return Err(RecordingError::Empty { file: file.to_string() });
    }
    let names = row
        .iter()
        .map(|field| std::str::from_utf8(field).map(|name| name.trim().to_string()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|_| RecordingError::NotText { file: file.to_string(), line: 1 })?;
    let header = Header::parse(file, names, purpose)?;
    let mut content = vec![Content::Unknown; header.further.len()];

    let (mut time_s, mut pass, mut direction) = (Vec::new(), Vec::new(), Vec::new());
    let (mut command, mut first, mut second, mut reference) = (vec![], vec![], vec![], vec![]);
    let mut further: Vec<Vec<f64>> = vec![Vec::new(); header.further.len()];
    let (mut watch, mut lines) = (Watch::default(), Lines::default());
    while reader.read_byte_record(&mut row).map_err(broken)? {
        // A record begins, for the reader, where the one before ended: blank lines stand in between. It
        // ends in the line before the reader's, or in the reader's if the file ends without a line feed.
        let begun = row.position().map_or(0, |position| position.line());
        let line = begun.max(reader.position().line() - 1);
        if row.len() == 1 && row[0].trim_ascii().is_empty() {
            continue;
        }
        if row.len() != header.roles.len() {
            let (found, expected) = (row.len() as u64, header.roles.len() as u64);
            return Err(RecordingError::FieldCount { file: file.to_string(), line, found, expected });
        }
        for (index, (role, field)) in header.roles.iter().zip(row.iter()).enumerate() {
            let place = || Place { file: file.to_string(), line, column: header.names[index].clone() };
            let field = field.trim_ascii();
            match *role {
                Role::Time => time_s.push(needed(field, place)?),
                Role::First => first.push(needed(field, place)?),
                Role::Second => second.push(needed(field, place)?),
                Role::Reference => reference.push(needed(field, place)?),
                Role::Command => command.push(optional(field, place)?),
                Role::Pass => {
                    let number = needed(field, place)?;
                    if number.fract() != 0.0 || number.abs() > 1e9 {
                        return Err(RecordingError::PassNumber { place: place(), found: shown(field) });
                    }
                    pass.push(number as i32);
                }
                Role::Direction => match needed(field, place)? {
                    1.0 => direction.push(1i8),
                    -1.0 => direction.push(-1i8),
                    _ => return Err(RecordingError::Direction { place: place(), found: shown(field) }),
                },
                Role::Further(which) => {
                    if content[which] == Content::Unknown && !field.is_empty() {
                        content[which] = match parse(field) {
                            Some(_) => Content::Numbers,
                            None => Content::Text,
                        };
                    }
                    if content[which] != Content::Text {
                        further[which].push(optional(field, place)?);
                    }
                }
            }
        }
        lines.push(time_s.len() - 1, line);
        watch.row(&time_s);
    }
    if time_s.is_empty() {
        return Err(RecordingError::NoRows { file: file.to_string() });
    }
    let mut notes: Vec<Note> = watch.note(&time_s, &lines).into_iter().collect();
    if !header.has(Role::Pass) {
        pass = vec![0; time_s.len()];
        notes.push(Note::Assumed { column: "pass" });
    }
    if !header.has(Role::Direction) {
        direction = vec![1; time_s.len()];
        notes.push(Note::Assumed { column: "direction" });
    }
    let reference = header.has(Role::Reference).then_some(reference);
    let mut columns = Vec::new();
    for ((name, values), content) in header.further.iter().zip(further).zip(content) {
        match content {
            Content::Numbers => columns.push(Column { name: name.clone(), values }),
            _ => notes.push(Note::TextColumn { column: name.clone() }),
        }
    }
    let recording = Recording {
        file: file.to_string(),
        sha256: String::new(),
        time_s,
        pass,
        direction,
        command_deg: header.has(Role::Command).then_some(command),
        readings: if header.direct {
            Readings::Direct { measured: first, reference }
        } else {
            Readings::Pair { x1_mm: first, x2_mm: second, reference_arcsec: reference }
        },
        further: columns,
        notes,
        lines,
    };
    watch.duplicates(&recording)?;
    if purpose == Purpose::Fit {
        checks::empty_pass(&recording)?;
    }
    Ok(recording)
}

/// The field as a number, `None` if it is not one. "nan" and "inf" are numbers here and refused later.
fn parse(field: &[u8]) -> Option<f64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}

/// The field as text for a message, cut to a length that a person reads.
fn shown(field: &[u8]) -> String {
    let text = String::from_utf8_lossy(field);
    match text.char_indices().nth(40) {
        Some((at, _)) => format!("{}…", &text[..at]),
        None => text.into_owned(),
    }
}

fn needed(field: &[u8], place: impl Fn() -> Place) -> Result<f64, RecordingError> {
    match parse(field) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(RecordingError::NotFinite { place: place(), found: shown(field) }),
        None if field.is_empty() => Err(RecordingError::Blank { place: place() }),
        None => Err(RecordingError::NotANumber { place: place(), found: shown(field) }),
    }
}

fn optional(field: &[u8], place: impl Fn() -> Place) -> Result<f64, RecordingError> {
    if field.is_empty() { Ok(f64::NAN) } else { needed(field, place) }
}
