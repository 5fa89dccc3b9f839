//! Kinds of files that are no text. Each is read by a crate of its own, which a program adds.

use std::fs::File;
use std::sync::{PoisonError, RwLock};

use super::{Naming, RecordingError, Table, Uses};

/// Reads the file of that name; the hash of the table is left blank.
pub type Read = fn(&str, File, &Naming, &Uses) -> Result<Table, RecordingError>;

/// A kind of file.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Its first bytes, by which it is known.
    pub begins_with: [u8; 4],
    /// What reads it.
    pub read: Read,
}

static ADDED: RwLock<Vec<Format>> = RwLock::new(Vec::new());

/// From now on [`Table::read`] reads such files too, in the whole process.
pub fn add_format(format: Format) {
    let mut added = ADDED.write().unwrap_or_else(PoisonError::into_inner);
    added.retain(|other| other.begins_with != format.begins_with);
    added.push(format);
}

/// What reads a file that begins so.
pub(super) fn reader(head: &[u8]) -> Option<Read> {
    let added = ADDED.read().unwrap_or_else(PoisonError::into_inner);
    added.iter().find(|format| head == format.begins_with).map(|format| format.read)
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::super::{Cell, Columns, Dialect, Header, Use};
    use super::*;

    /// Two columns of bytes, after four that say what it is.
    fn pairs(file: &str, mut source: File, naming: &Naming, uses: &Uses) -> Result<Table, RecordingError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).unwrap();
        let names = vec!["t_s".to_string(), "angle_deg".to_string()];
        let mut columns = Columns::new(file, (file.to_string(), None), names, naming, uses)?;
        for (line, row) in (1..).zip(bytes[4..].chunks(2)) {
            for (index, value) in row.iter().enumerate() {
                columns.cell(line, index, Cell::Number((*value).into()), || value.to_string())?;
            }
            columns.row(line);
        }
        columns.finish(Dialect::PLAIN)
    }

    #[test]
    fn a_format_is_read_once_it_is_added() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bytes.pairs");
        std::fs::write(&path, b"\x7fpr1\x00\x07\x01\x09").unwrap();
        let uses = |header: &Header| Ok(vec![Use::Needed; header.names.len()]);
        let read = || Table::read(&path, &Naming::default(), &uses, &mut |_| {});
        read().unwrap_err();
        add_format(Format { begins_with: *b"\x7fpr1", read: pairs });
        let table = read().unwrap();
        assert_eq!(&table.columns[1].values[..], [7.0, 9.0]);
        assert_eq!((table.rows, table.sha256.len()), (2, 64));
    }
}
