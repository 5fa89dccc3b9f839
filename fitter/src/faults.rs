//! Cells that cannot be readings: found before anything is fitted, named with their line, and left out.

use serde::Serialize;

/// A cell that cannot be a reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BadRow {
    /// Its line in the file, the header being line 1.
    pub line: u64,
    /// Its column.
    pub column: String,
    /// What stands there.
    pub value: String,
    /// Why it cannot be a reading, with how far it is from what the other rows say.
    pub reason: String,
}
