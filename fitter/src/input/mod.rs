//! How files are read, and how much of them at most: the one place of all limits.
//!
//! A limit is there so that a file that is not what it seems (a gzip file of zeros, a device) ends in a message and
//! not in the machine's memory. Two of them can be raised: [`limit`].

mod error;
mod kind;
mod section;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use flate2::bufread::MultiGzDecoder;

use crate::text_safety;
pub use error::{FileError, LimitError};
use kind::is_utf16;
pub use kind::{Kind, expect};
pub use section::{PROJECT_FILE, section, toml};

/// Bytes of a file, decompressed: beyond ten million rows of ten columns. In memory a recording takes about as much.
pub const MAX_BYTES: u64 = 1 << 30;
/// Columns of a recording. The time and memory of a diagnosis grow with their square, to some gigabytes.
pub const MAX_COLUMNS: u64 = 512;

static BYTES: AtomicU64 = AtomicU64::new(MAX_BYTES);
static COLUMNS: AtomicU64 = AtomicU64::new(MAX_COLUMNS);

/// Sets what holds in this process from now on; none is the default.
pub fn limit(bytes: Option<u64>, columns: Option<u64>) {
    BYTES.store(bytes.unwrap_or(MAX_BYTES), Ordering::Relaxed);
    COLUMNS.store(columns.unwrap_or(MAX_COLUMNS), Ordering::Relaxed);
}

/// Most bytes of a recording.
pub fn max_bytes() -> u64 {
    BYTES.load(Ordering::Relaxed)
}

/// Most bytes of a JSON or TOML file: parsed, each takes some sixteen times its place. Small ones are always read.
fn max_parsed() -> u64 {
    (max_bytes() / 16).max(1 << 20).min(max_bytes())
}

/// Most bytes of a line, so that one without end is refused before the memory is full.
fn max_line() -> u64 {
    (max_bytes() / 1024).max(1 << 16)
}

/// Refuses more columns than are read.
///
/// # Errors
/// [`LimitError::Columns`].
pub fn check_columns(count: usize) -> Result<(), LimitError> {
    let (found, most) = (count as u64, COLUMNS.load(Ordering::Relaxed));
    if found > most { Err(LimitError::Columns { found, most }) } else { Ok(()) }
}

/// A source of which no more is read than the limits allow; what is beyond them is an error that holds a [`LimitError`].
pub struct Limited<R> {
    inner: R,
    left: u64,
    /// Bytes since the last end of a line.
    line: u64,
    decompressed: bool,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        let read = count as u64;
        self.line = match buffer[..count].iter().rposition(|byte| *byte == b'\n') {
            Some(at) => read - at as u64 - 1,
            None => self.line + read,
        };
        let error = if read > self.left {
            LimitError::Bytes { most: max_bytes(), decompressed: self.decompressed }
        } else if self.line > max_line() {
            LimitError::Line { most: max_line() }
        } else {
            self.left -= read;
            return Ok(count);
        };
        Err(io::Error::other(error))
    }
}

/// Whether a file is compressed: by its name, or, as from a pipe, by its first bytes.
pub fn is_gzip(file: &str, head: &[u8]) -> bool {
    file.ends_with(".gz") || head.starts_with(&[0x1f, 0x8b])
}

/// The lines of a source within the limits, decompressed where it is so.
pub fn text<'a>(source: impl io::BufRead + 'a, gzip: bool) -> Limited<Box<dyn Read + 'a>> {
    let inner: Box<dyn Read> = if gzip { Box::new(MultiGzDecoder::new(source)) } else { Box::new(source) };
    Limited { inner, left: max_bytes(), line: 0, decompressed: gzip }
}

/// The text of a file that is parsed as a whole, JSON or TOML, and is to be an `expected` one.
///
/// # Errors
/// [`FileError::Unreadable`], of bytes that are no UTF-8 text as well, or [`FileError::Limit`].
pub fn parsed(path: &Path, expected: &'static str) -> Result<String, FileError> {
    let file = || text_safety::path(path);
    let unreadable = |reason: String| FileError::Unreadable { file: file(), reason, expected };
    let (mut bytes, most) = (Vec::new(), max_parsed());
    File::open(path)
        .and_then(|source| source.take(most.saturating_add(1)).read_to_end(&mut bytes))
        .map_err(|error| unreadable(error.to_string()))?;
    if bytes.len() as u64 > most {
        return Err(FileError::Limit { file: file(), limit: LimitError::Parsed { most } });
    }
    let reason = match &bytes[..] {
        [0x1f, 0x8b, ..] => "it is a gzip file, as of a recording",
        [b'P', b'A', b'R', b'1', ..] => "it is a Parquet file, as of a recording",
        text if is_utf16(text) => "it is UTF-16; save it as UTF-8",
        _ => "it is not UTF-8 text",
    };
    String::from_utf8(bytes).map_err(|_| unreadable(reason.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_lines(lines: usize, line: usize) -> io::Result<usize> {
        let text = [vec![b'1'; line - 1], vec![b'\n']].concat().repeat(lines);
        let mut source = Limited { inner: &text[..], left: 1 << 20, line: 0, decompressed: false };
        source.read_to_end(&mut Vec::new())
    }

    #[test]
    fn a_source_ends_at_its_limit_and_not_before() {
        assert_eq!(of_lines(1 << 14, 64).unwrap(), 1 << 20);
        let beyond = of_lines((1 << 14) + 1, 64).unwrap_err();
        assert!(matches!(LimitError::of(&beyond), Some(LimitError::Bytes { .. })), "{beyond}");
    }

    #[test]
    fn a_line_without_end_is_told() {
        let text = vec![0; (max_line() + 1) as usize];
        let mut source = Limited { inner: &text[..], left: u64::MAX, line: 0, decompressed: true };
        let error = io::copy(&mut source, &mut io::sink()).unwrap_err();
        assert!(LimitError::of(&error).unwrap().to_string().contains("a line of more than"));
    }
}
