//! Why a file is not read, whatever it holds.

use std::io;

use super::Kind;

errors! {
    /// Something is larger than is read.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub enum LimitError {
        Bytes { most: u64, decompressed: bool } =>
            says("holds more than {most} bytes{}", if *decompressed { ", decompressed" } else { "" })
            mend("if that is meant, allow more bytes") by(max_bytes);
        Parsed { most: u64 } =>
            says("holds more than {most} bytes, a 16th of what a recording may hold")
            mend("if that is meant, allow more bytes") by(max_bytes);
        Line { most: u64 } =>
            says("has a line of more than {most} bytes, a 1024th of what a recording may hold")
            expected("one line for each reading") mend("if that is meant, allow more bytes") by(max_bytes);
        Columns { found: u64, most: u64 } =>
            says("has {found} columns") expected("at most {most}")
            mend("drop some, or allow more columns") by(max_columns);
    }
}

impl LimitError {
    /// The limit that ended a reading, if one did.
    pub fn of(error: &io::Error) -> Option<LimitError> {
        error.get_ref()?.downcast_ref::<LimitError>().cloned()
    }
}

errors! {
    /// Why a file is refused before it is parsed.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub enum FileError {
        Unreadable { file: String, reason: String, expected: &'static str } =>
            at(file) says("cannot be read ({reason})") mend("give the path of a {expected}");
        Limit { file: String, limit: LimitError } => of(limit) at(file);
        /// It is another than the one that belongs there.
        Kind { file: String, found: Kind, expected: Kind } =>
            at(file) says("is {found}") expected("{expected}") mend("give that in its place");
        Utf16 { file: String } => at(file) says("is UTF-16") expected("UTF-8") mend("save it as UTF-8");
    }
}
