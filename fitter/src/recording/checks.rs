//! Checks that need more than one row.

use super::{Note, Recording};

/// Which line of the file a row stands on: blank lines are skipped, so that it is not simply the row's
/// number. Only the rows are kept whose line does not follow that of the row before.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Lines {
    jumps: Vec<(usize, u64)>,
}

impl Lines {
    pub fn push(&mut self, row: usize, line: u64) {
        if row == 0 || self.of(row) != line {
            self.jumps.push((row, line));
        }
    }

    pub fn of(&self, row: usize) -> u64 {
        let after = self.jumps.partition_point(|(first, _)| *first <= row);
        match self.jumps[..after].last() {
            Some((first, line)) => line + (row - first) as u64,
            None => row as u64 + 2,
        }
    }
}

/// Where the times do not increase.
#[derive(Default)]
pub(super) struct Watch {
    /// The first row whose time is before that of the row above.
    backward: Option<usize>,
}

impl Watch {
    /// Called once for every row, after its time was pushed to `time_s`.
    pub fn row(&mut self, time_s: &[f64]) {
        if let [.., before, now] = time_s
            && now < before
            && self.backward.is_none()
        {
            self.backward = Some(time_s.len() - 1);
        }
    }

    pub fn note(&self, time_s: &[f64], lines: &Lines) -> Option<Note> {
        self.backward.map(|row| Note::TimeBackward {
            line: lines.of(row),
            from_s: time_s[row - 1],
            to_s: time_s[row],
        })
    }
}

/// A pass number between the smallest and the largest that no row has. In a recording of one direction only the passes
/// of the other are rightly missing.
pub(super) fn empty_pass(recording: &Recording) -> Option<Note> {
    let (passes, direction) = (recording.passes(), &recording.direction);
    if direction.iter().all(|d| *d == direction[0]) {
        return None;
    }
    let gap = passes.windows(2).find(|pair| i64::from(pair[1]) > i64::from(pair[0]) + 1)?;
    Some(Note::EmptyPass {
        pass: i64::from(gap[0]) + 1,
        first: i64::from(passes[0]),
        last: i64::from(passes[passes.len() - 1]),
    })
}
