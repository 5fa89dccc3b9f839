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
