//! Files of keys in TOML, `mirror.toml` and `plant.toml`: how they are read, and what is refused in them.

use std::path::Path;

use crate::input::{self, FileError};
use crate::table::nearest;
use crate::text_safety;

errors! {
    /// Why such a file is refused.
    #[derive(Debug)]
    pub enum KeyError {
        Syntax { file: String, line: usize, reason: String } =>
            at(file) line(line) says("{reason}") mend("correct the line");
        Unknown { file: String, found: String, expected: String, nearest: Option<String> } =>
            at(file) says("{found}") expected("{expected}")
            mend("{}", nearest.as_ref().map_or("remove it".into(), |n| format!("did you mean `{n}`?")));
        MissingKey { file: String, key: &'static str, expected: &'static str } =>
            at(file) says("`{key}` is missing") expected("{expected}") mend("add it");
        Value { file: String, key: String, found: String, expected: &'static str } =>
            at(file) says("`{key}` is {found}") expected("{expected}") mend("correct it");
    }
    from { File(FileError) }
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

/// Reads the file at `path`, which is to be an `expected` one, by `parse`: of its name in messages and its text. A project
/// file may stand in its place, which has these `tables`.
pub(crate) fn read<T>(
    path: &Path,
    expected: &'static str,
    tables: &[&str],
    parse: impl FnOnce(&str, &str) -> Result<T, KeyError>,
) -> Result<T, KeyError> {
    parse(&text_safety::path(path), &input::toml(path, expected, tables)?)
}
