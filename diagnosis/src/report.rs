//! The report.

use crate::diagnosis::Outcome;

/// The page.
pub fn page(_outcome: &Outcome) -> String {
    String::new()
}
