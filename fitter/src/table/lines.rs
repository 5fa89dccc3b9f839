//! Which line of the file a row stands on.

/// The name of a table in memory, unless it is given another; a word before it says which: `held-out table`.
pub const IN_MEMORY: &str = "table";

/// Whether the rows of a file are counted from 1 in messages, because it has no lines.
pub(crate) fn counts_rows(file: &str) -> bool {
    file.ends_with(".parquet") || file.split(' ').next_back() == Some(IN_MEMORY)
}

/// The line of every row: blank lines and comments are skipped, so that it is not simply the row's number. Only the
/// rows are kept whose line does not follow that of the row before.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lines {
    jumps: Vec<(usize, u64)>,
}

impl Lines {
    /// Row `row` stands on `line`.
    pub fn push(&mut self, row: usize, line: u64) {
        if row == 0 || self.of(row) != line {
            self.jumps.push((row, line));
        }
    }

    /// The line of a row, the first line of the file being 1.
    pub fn of(&self, row: usize) -> u64 {
        let after = self.jumps.partition_point(|(first, _)| *first <= row);
        match self.jumps[..after].last() {
            Some((first, line)) => line + (row - first) as u64,
            None => row as u64 + 2,
        }
    }
}
