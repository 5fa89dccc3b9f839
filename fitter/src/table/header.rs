//! The names of a file's columns.

use strsim::levenshtein;

use super::{Place, RecordingError};
use crate::message::FileLine;
use crate::text_safety;

/// The header of a file, its columns under the names that they are mapped to.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// The file as it is named in messages.
    pub file: String,
    /// Where the header stands: the file and the line.
    pub at: FileLine,
    /// The names, none of them twice.
    pub names: Vec<String>,
    /// The names as they stand in the file.
    pub in_file: Vec<String>,
}

impl Header {
    /// Refuses names that are blank, double, or may not reach sources and pages.
    pub(super) fn check(&self) -> Result<(), RecordingError> {
        let at = || self.at.clone();
        if let [one] = &self.names[..]
            && one.contains(' ')
        {
            return Err(RecordingError::Separator { at: at() });
        }
        for (index, name) in self.names.iter().enumerate() {
            let number = index + 1;
            if name.is_empty() {
                return Err(RecordingError::UnnamedColumn { at: at(), number });
            }
            if self.names[..index].contains(name) {
                return Err(RecordingError::DoubledColumn { at: at(), column: name.clone() });
            }
            text_safety::name(name).map_err(|reason| {
                let column = text_safety::excerpt(name, 40);
                RecordingError::UnsafeColumn { at: at(), number, column, reason }
            })?;
        }
        Ok(())
    }

    /// Whether there is a column of that name.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|other| other == name)
    }

    /// The names of all columns, for messages.
    pub fn listed(&self) -> String {
        self.in_file.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    }

    /// Refuses a header in which one of these columns is missing.
    ///
    /// # Errors
    /// [`RecordingError::MissingColumns`] names all of them.
    pub fn require(&self, needed: &[&str]) -> Result<(), RecordingError> {
        let missing: Vec<&str> = needed.iter().copied().filter(|name| !self.has(name)).collect();
        if missing.is_empty() {
            return Ok(());
        }
        let free = || self.names.iter().map(String::as_str).filter(|name| !needed.contains(name));
        // A column stands for one that is missing at most: for the nearest.
        let is_for = |name: &str, similar: &&str| nearest(similar, missing.iter().copied()) == Some(name);
        let similar = |name: &str| nearest(name, free()).filter(|similar| is_for(name, similar));
        Err(RecordingError::MissingColumns {
            at: self.at.clone(),
            found: self.listed(),
            missing: missing
                .iter()
                .map(|name| (name.to_string(), similar(name).map(str::to_string)))
                .collect(),
        })
    }

    /// Where a cell is, for a message; the column is named as in the file.
    pub fn place(&self, line: u64, column: &str) -> Place {
        let at = self.names.iter().position(|name| name == column);
        let column = at.map_or(column, |at| &self.in_file[at]).to_string();
        Place { file: self.file.clone(), line, column }
    }
}

/// The columns of one kind among `names`: `drive` alone, or `drive_1`, `drive_2`, ….
pub fn family(names: &[String], stem: &str) -> Vec<String> {
    let has = |name: &String| names.contains(name);
    match names.iter().find(|name| *name == stem) {
        Some(one) => vec![one.clone()],
        None => (1..).map(|number| format!("{stem}_{number}")).take_while(has).collect(),
    }
}

/// The candidate nearest to `wanted` by edit distance, if it is near enough to be a slip of the pen: at
/// most a third of the letters changed, or the same word with another unit after its last `_`.
pub fn nearest<'a>(wanted: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let stem = |name: &str| name.rsplit_once('_').map_or(name.to_string(), |(stem, _)| stem.to_lowercase());
    candidates
        .map(|name| {
            let distance = levenshtein(&wanted.to_lowercase(), &name.to_lowercase());
            (if stem(wanted) == stem(name) { distance.min(1) } else { distance }, name)
        })
        .filter(|(distance, name)| *distance <= wanted.len().max(name.len()) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}
