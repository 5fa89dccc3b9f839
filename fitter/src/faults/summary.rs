//! What a terminal says of cells that cannot be readings.

use super::BadRow;
use crate::summary::{LABEL, WARNING, line};

/// So many cells are listed unless everything is.
const LISTED: usize = 4;

/// One line for each of the first cells, and how many more there are; then the findings that removed nothing.
pub fn styled(bad_rows: &[BadRow], notes: &[String], verbose: bool) -> String {
    let listed = if verbose { usize::MAX } else { LISTED };
    let mut text = String::new();
    for bad in bad_rows.iter().take(listed) {
        let BadRow { line: number, column, value, reason } = bad;
        text +=
            &format!("{WARNING}{:<12}{WARNING:#} line {number}, {column} {value}: {reason}\n", "left out");
    }
    if bad_rows.len() > listed {
        text += &format!("{LABEL}{:<12}{LABEL:#} and {} more (-v lists them)\n", "", bad_rows.len() - listed);
    }
    for note in notes.iter().take(listed) {
        text += &line("found", note);
    }
    text
}
