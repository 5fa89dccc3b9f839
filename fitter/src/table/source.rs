//! Where a table comes from: a file, a pipe, or bytes; packed or not, text or another format.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::columns::Uses;
use super::text::{self, BUFFER};
use super::{Naming, RecordingError, Table, format};
use crate::input;
use crate::text_safety;

impl Table {
    /// Reads the file at `path`; gzip is known by its name or its first bytes, a format that was added
    /// ([`add_format`](super::add_format)) by its first bytes. `uses` says which columns are taken, and `progress` is called
    /// with the number of bytes read so far.
    ///
    /// # Errors
    /// One of [`RecordingError`], with the line and the column where there is one.
    pub fn read(
        path: &Path,
        naming: &Naming,
        uses: &Uses,
        progress: &mut dyn FnMut(u64),
    ) -> Result<Table, RecordingError> {
        let shown = text_safety::path(path);
        let unreadable = |error: io::Error| RecordingError::of(&shown, &error, false);
        let mut file = File::open(path).map_err(unreadable)?;
        if file.metadata().map_err(unreadable)?.is_dir() {
            return Err(RecordingError::IsDirectory { file: shown });
        }
        let mut head = Vec::new();
        file.by_ref().take(4).read_to_end(&mut head).map_err(unreadable)?;
        // A pipe cannot be read again from its beginning: what was read is put before the rest.
        let table = match (format::reader(&head), &head[..]) {
            (Some(read), _) => {
                let file = if file.rewind().is_ok() { Ok(file) } else { spooled(head.chain(file)) };
                seekable(read, &shown, file.map_err(unreadable)?, naming, uses, progress)?
            }
            (None, b"PAR1") => return Err(RecordingError::NoParquet { file: shown }),
            (None, b"TDSm") => return Err(RecordingError::NoTdms { file: shown }),
            _ => {
                let gzip = input::is_gzip(&shown, &head);
                hashed(&shown, head.chain(file), gzip, naming, uses, progress)?
            }
        };
        Ok(Table { file: text_safety::file_name(path), ..table })
    }

    /// Reads a table from bytes; `file` is the name that stands in messages and provenance, and a name
    /// that ends in `.gz` is decompressed.
    ///
    /// # Errors
    /// As [`Table::read`].
    pub fn from_bytes(
        file: &str,
        bytes: &[u8],
        naming: &Naming,
        uses: &Uses,
    ) -> Result<Table, RecordingError> {
        hashed(file, bytes, input::is_gzip(file, bytes), naming, uses, &mut |_| {})
    }
}

/// Hashes and counts what passes through.
struct Hashing<'a, R> {
    inner: R,
    hash: Sha256,
    bytes: u64,
    progress: &'a mut dyn FnMut(u64),
}

impl<'a, R: Read> Hashing<'a, R> {
    fn new(inner: R, progress: &'a mut dyn FnMut(u64)) -> Hashing<'a, R> {
        Hashing { inner, hash: Sha256::new(), bytes: 0, progress }
    }

    /// The hash of all bytes, those that nobody has read included.
    fn finish(mut self) -> io::Result<String> {
        io::copy(&mut self, &mut io::sink())?;
        Ok(self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

impl<R: Read> Read for Hashing<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.hash.update(&buffer[..count]);
        self.bytes += count as u64;
        (self.progress)(self.bytes);
        Ok(count)
    }
}

/// Reads text and hashes its bytes as they lie on disk.
fn hashed(
    file: &str,
    source: impl Read,
    gzip: bool,
    naming: &Naming,
    uses: &Uses,
    progress: &mut dyn FnMut(u64),
) -> Result<Table, RecordingError> {
    let mut raw = BufReader::with_capacity(BUFFER, Hashing::new(source, progress));
    let table = text::read(file, input::text(&mut raw, gzip), gzip, naming, uses)?;
    let sha256 = raw.into_inner().finish().map_err(|error| RecordingError::of(file, &error, false))?;
    Ok(Table { sha256, ..table })
}

/// A file that can be read in any order, of what perhaps cannot.
fn spooled(mut source: impl Read) -> io::Result<File> {
    let mut file = tempfile::tempfile()?;
    let most = input::max_bytes();
    if io::copy(&mut source.by_ref().take(most.saturating_add(1)), &mut file)? > most {
        let limit = input::LimitError::Bytes { most, decompressed: false };
        return Err(io::Error::other(limit));
    }
    file.rewind()?;
    Ok(file)
}

/// Hashes a file that is no text and reads it.
fn seekable(
    read: format::Read,
    file: &str,
    mut source: File,
    naming: &Naming,
    uses: &Uses,
    progress: &mut dyn FnMut(u64),
) -> Result<Table, RecordingError> {
    let unreadable = |error: io::Error| RecordingError::of(file, &error, false);
    let sha256 = Hashing::new(&mut source, progress).finish().map_err(unreadable)?;
    source.rewind().map_err(unreadable)?;
    Ok(Table { sha256, ..read(file, source, naming, uses)? })
}
