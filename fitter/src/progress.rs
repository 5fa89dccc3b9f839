//! How a library tells a program how far a long piece of work is.

/// Someone who watches. Nobody does by default: `()`.
pub trait Progress: Sync {
    /// What is being done now.
    fn doing(&self, _what: &str) {}
    /// It has so many steps, none of them done.
    fn steps(&self, _count: u64) {}
    /// So many more steps are done.
    fn advance(&self, _steps: u64) {}
    /// Something that does not end the work, in a sentence.
    fn warn(&self, _text: &str) {}
}

impl Progress for () {}
