//! Which field of a row is which column.

use super::{Purpose, RecordingError};
use crate::text_safety;

/// What a field of a row is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Role {
    Time,
    Pass,
    Direction,
    Command,
    /// x₁, or the direct sensor's reading.
    First,
    /// x₂.
    Second,
    Reference,
    /// Further observable number so-and-so.
    Further(usize),
}

/// The header, understood.
#[derive(Debug)]
pub(super) struct Header {
    pub roles: Vec<Role>,
    pub further: Vec<String>,
    pub direct: bool,
}

impl Header {
    pub fn has(&self, role: Role) -> bool {
        self.roles.contains(&role)
    }

    pub fn parse(file: &str, names: Vec<String>, purpose: Purpose) -> Result<Header, RecordingError> {
        let file = file.to_string();
        if names.len() == 1 && names[0].contains(' ') {
            return Err(RecordingError::Separator { file, found: "spaces" });
        }
        for (index, name) in names.iter().enumerate() {
            if name.is_empty() {
                return Err(RecordingError::UnnamedColumn { file, number: index + 1 });
            }
            if names[..index].contains(name) {
                return Err(RecordingError::DoubledColumn { file, column: name.clone() });
            }
            safe_column(&file, index, name)?;
        }
        let present = |wanted: &str| names.iter().any(|name| name == wanted);
        let first_of =
            |wanted: &[&str]| wanted.iter().find(|name| present(name)).map(|name| name.to_string());
        let pair = first_of(&["x1_mm", "x2_mm", "reference_arcsec"]);
        let direct = first_of(&["measured", "reference"]);
        if let (Some(pair), Some(direct)) = (&pair, &direct) {
            return Err(RecordingError::TwoSensors { file, pair: pair.clone(), direct: direct.clone() });
        }
        let direct = direct.is_some();
        let mut needed = vec!["t_s"];
        if purpose == Purpose::Fit {
            needed.extend(["pass", "direction"]);
        }
        needed.extend(if direct { &["measured"][..] } else { &["x1_mm", "x2_mm"] });
        if purpose == Purpose::Fit {
            needed.push(if direct { "reference" } else { "reference_arcsec" });
        }
        if let Some(column) = needed.into_iter().find(|name| !present(name)) {
            let similar = nearest(column, names.iter().map(String::as_str)).map(str::to_string);
            let found = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            return Err(RecordingError::MissingColumn { file, column: column.to_string(), found, similar });
        }
        let mut further = Vec::new();
        let roles = names
            .iter()
            .map(|name| match name.as_str() {
                "t_s" => Role::Time,
                "pass" => Role::Pass,
                "direction" => Role::Direction,
                "command_deg" => Role::Command,
                "x1_mm" | "measured" => Role::First,
                "x2_mm" => Role::Second,
                "reference_arcsec" | "reference" => Role::Reference,
                _ => {
                    further.push(name.clone());
                    Role::Further(further.len() - 1)
                }
            })
            .collect();
        Ok(Header { roles, further, direct })
    }
}

/// Whether a column's name, the `index`th of the header, may reach sources and pages.
///
/// # Errors
/// [`RecordingError::UnsafeColumn`].
pub fn safe_column(file: &str, index: usize, name: &str) -> Result<(), RecordingError> {
    text_safety::name(name).map_err(|reason| RecordingError::UnsafeColumn {
        file: file.to_string(),
        number: index + 1,
        column: text_safety::excerpt(name, 40),
        reason,
    })
}

/// The candidate nearest to `wanted` by edit distance, if it is near enough to be a slip of the pen: at
/// most a third of the letters changed, or the same word with another unit after its last `_`.
pub(crate) fn nearest<'a>(wanted: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let stem = |name: &str| name.rsplit_once('_').map_or(name.to_string(), |(stem, _)| stem.to_lowercase());
    candidates
        .map(|name| {
            let distance = edit_distance(&wanted.to_lowercase(), &name.to_lowercase());
            (if stem(wanted) == stem(name) { distance.min(1) } else { distance }, name)
        })
        .filter(|(distance, name)| *distance <= wanted.len().max(name.len()) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}
