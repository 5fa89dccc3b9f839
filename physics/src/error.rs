//! What is wrong with an expression, and where.

use std::ops::Range;

use thiserror::Error;

/// A text that is no expression, or one whose parts do not go together.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("column {}: {what}", column(.text, .span.start))]
pub struct ExpressionError {
    /// The whole text.
    pub text: String,
    /// The bytes of it that are wrong.
    pub span: Range<usize>,
    /// Found, expected, mend.
    pub what: String,
}

impl ExpressionError {
    pub(crate) fn new(text: &str, span: &Range<usize>, what: impl Into<String>) -> ExpressionError {
        ExpressionError { text: text.to_string(), span: span.clone(), what: what.into() }
    }
}

/// Which character of a text a byte belongs to, the first being 1.
fn column(text: &str, byte: usize) -> usize {
    text.char_indices().take_while(|(at, _)| *at < byte).count() + 1
}

/// `word`, with the nearest of `known` suggested.
pub(crate) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    /// Names less alike are no slip of the keyboard.
    const ALIKE: f64 = 0.7;
    known
        .map(|name| (strsim::normalized_damerau_levenshtein(word, name), name))
        .filter(|(alike, _)| *alike >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
