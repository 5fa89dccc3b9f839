//! What a file is, as its first bytes say, so that one in the wrong place is refused for what it is.

use super::FileError;

/// A kind of file that the programs read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A recording, CSV or Parquet.
    Recording,
    /// `mirror.toml`.
    Mirror,
    /// `plant.toml`.
    Plant,
    /// `coefficients.json`.
    Coefficients,
    /// What `diagnose` writes about a recording.
    Diagnosis,
    /// Other JSON.
    Json,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Kind::Recording => "a recording",
            Kind::Mirror => "a mirror file (TOML)",
            Kind::Plant => "a plant file (TOML)",
            Kind::Coefficients => "a coefficients file (JSON)",
            Kind::Diagnosis => "the JSON of a diagnosis",
            Kind::Json => "JSON",
        })
    }
}

/// Refuses a file that begins as one of another kind, or as UTF-16.
///
/// # Errors
/// [`FileError::Kind`], [`FileError::Utf16`].
pub fn expect(file: &str, head: &[u8], expected: Kind) -> Result<(), FileError> {
    if is_utf16(head) {
        return Err(FileError::Utf16 { file: file.to_string() });
    }
    match of(head) {
        Some(found) if found != expected && !(found == Kind::Json && expected == Kind::Coefficients) => {
            Err(FileError::Kind { file: file.to_string(), found, expected })
        }
        _ => Ok(()),
    }
}

/// The kind of a file that begins with these bytes; none where it may be of any.
fn of(head: &[u8]) -> Option<Kind> {
    if head.starts_with(b"PAR1") {
        return Some(Kind::Recording);
    }
    let text = String::from_utf8_lossy(&head[..head.len().min(1 << 12)]);
    let lines = || {
        text.trim_start_matches('\u{feff}')
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
    };
    let first = lines().next()?;
    if first.starts_with('{') {
        let holds = |key: &str| text.contains(key);
        let kinds = [("\"arcsmith-coefficients\"", Kind::Coefficients), ("\"verdict\"", Kind::Diagnosis)];
        let known = kinds.into_iter().find(|(key, _)| holds(key));
        return Some(known.map_or(Kind::Json, |(_, kind)| kind));
    }
    let has = |section: &str| lines().any(|line| line == section);
    if ["[plant]", "[state_space]", "[[effects]]"].into_iter().any(has) {
        Some(Kind::Plant)
    } else if ["[geometry]", "[sensor]", "[reference]"].into_iter().any(has) {
        Some(Kind::Mirror)
    } else {
        let is_header = !first.contains(['=', '[', '{']) && first.contains([',', ';', '\t']);
        is_header.then_some(Kind::Recording)
    }
}

/// Whether text begins as UTF-16: with its mark, or with letters of ASCII in two bytes each.
pub(super) fn is_utf16(head: &[u8]) -> bool {
    match head {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] => *a != 0 && *b != 0,
        _ => false,
    }
}
