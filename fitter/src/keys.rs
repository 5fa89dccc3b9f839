//! Files of keys in TOML, `mirror.toml` and `plant.toml`: how they are read, and what is refused in them.

use std::path::Path;

use thiserror::Error;

use crate::input::{self, Misplaced};
use crate::table::nearest;
use crate::text_safety;

/// Why such a file is refused.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say what the fields are
pub enum KeyError {
    #[error(transparent)]
    Misplaced(#[from] Misplaced),
    #[error("{file}: cannot be read ({reason}); give the path of a {expected}")]
    Unreadable { file: String, reason: String, expected: &'static str },
    #[error("{file}, line {line}: {reason}; correct the line")]
    Syntax { file: String, line: usize, reason: String },
    #[error(
        "{file}: {found}, expected {expected}{}",
        nearest.as_ref().map_or(String::from("; remove it"), |n| format!("; did you mean `{n}`?"))
    )]
    Unknown { file: String, found: String, expected: String, nearest: Option<String> },
    #[error("{file}: `{key}` is missing, expected {expected}; add it")]
    MissingKey { file: String, key: &'static str, expected: &'static str },
    #[error("{file}: `{key}` is {found}, expected {expected}; correct it")]
    Value { file: String, key: String, found: String, expected: &'static str },
}

impl KeyError {
    /// A name that is none of the `known` ones, with the nearest of them: `found` says what it is the name of, and
    /// `expected` lists the known ones.
    pub(crate) fn unknown(
        file: &str,
        name: &str,
        known: &[&str],
        found: String,
        expected: String,
    ) -> KeyError {
        let nearest = nearest(name, known.iter().copied()).map(str::to_string);
        KeyError::Unknown { file: file.to_string(), found, expected, nearest }
    }

    /// What the reader of TOML said of a `text`.
    pub(crate) fn syntax(file: &str, text: &str, error: &toml::de::Error) -> KeyError {
        let line = error.span().map_or(0, |span| 1 + text[..span.start].matches('\n').count());
        KeyError::Syntax { file: file.to_string(), line, reason: error.message().to_string() }
    }
}

/// Names for a message: `a`, `b`.
pub(crate) fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Reads the file at `path`, which is to be an `expected` one, by `parse`: of its name in messages and its text.
pub(crate) fn read<T>(
    path: &Path,
    expected: &'static str,
    parse: impl FnOnce(&str, &str) -> Result<T, KeyError>,
) -> Result<T, KeyError> {
    let file = text_safety::path(path);
    match input::parsed(path) {
        Ok(text) => parse(&file, &text),
        Err(error) => Err(KeyError::Unreadable { file, reason: error.to_string(), expected }),
    }
}
