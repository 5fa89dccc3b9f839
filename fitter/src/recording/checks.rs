//! Checks that need more than one row.

use super::{Note, Readings, Recording, RecordingError};

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
    /// Whether any row has the time of the row above, or an earlier one.
    suspicious: bool,
}

impl Watch {
    /// Called once for every row, after its time was pushed to `time_s`.
    pub fn row(&mut self, time_s: &[f64]) {
        if let [.., before, now] = time_s
            && now <= before
        {
            self.suspicious = true;
            if now < before && self.backward.is_none() {
                self.backward = Some(time_s.len() - 1);
            }
        }
    }

    pub fn note(&self, time_s: &[f64], lines: &Lines) -> Option<Note> {
        self.backward.map(|row| Note::TimeBackward {
            line: lines.of(row),
            from_s: time_s[row - 1],
            to_s: time_s[row],
        })
    }

    /// Refuses a row that repeats an earlier one in every column. Rows of different times differ, so that
    /// there is nothing to do where the times increase.
    pub fn duplicates(&self, recording: &Recording) -> Result<(), RecordingError> {
        if !self.suspicious {
            return Ok(());
        }
        let columns = columns(recording);
        let compare = |a: &usize, b: &usize| {
            (columns.iter().map(|column| column[*a].total_cmp(&column[*b])))
                .chain([
                    recording.pass[*a].cmp(&recording.pass[*b]),
                    recording.direction[*a].cmp(&recording.direction[*b]),
                ])
                .find(|order| order.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        };
        let mut rows: Vec<usize> = (0..recording.rows()).collect();
        rows.sort_by(compare); // stable: equal rows stay in the order of the file
        let repeated =
            rows.windows(2).filter(|pair| compare(&pair[0], &pair[1]).is_eq()).min_by_key(|pair| pair[1]);
        match repeated {
            Some(pair) => Err(RecordingError::DuplicateRow {
                file: recording.file.clone(),
                line: recording.line(pair[1]),
                first: recording.line(pair[0]),
                time_s: recording.time_s[pair[1]],
            }),
            None => Ok(()),
        }
    }
}

/// All columns of floating-point numbers, time first.
fn columns(recording: &Recording) -> Vec<&[f64]> {
    let mut columns: Vec<&[f64]> = vec![&recording.time_s];
    columns.extend(recording.command_deg.as_deref());
    match &recording.readings {
        Readings::Pair { x1_mm, x2_mm, reference_arcsec } => {
            columns.extend([x1_mm.as_slice(), x2_mm]);
            columns.extend(reference_arcsec.as_deref());
        }
        Readings::Direct { measured, reference } => {
            columns.push(measured);
            columns.extend(reference.as_deref());
        }
    }
    columns.extend(recording.further.iter().map(|column| column.values.as_slice()));
    columns
}

/// Refuses a pass number between the smallest and the largest that no row has. In a recording of one
/// direction only the passes of the other are rightly missing.
pub(super) fn empty_pass(recording: &Recording) -> Result<(), RecordingError> {
    let (passes, direction) = (recording.passes(), &recording.direction);
    if direction.iter().all(|d| *d == direction[0]) {
        return Ok(());
    }
    match passes.windows(2).find(|pair| i64::from(pair[1]) > i64::from(pair[0]) + 1) {
        Some(pair) => Err(RecordingError::EmptyPass {
            file: recording.file.clone(),
            pass: i64::from(pair[0]) + 1,
            first: i64::from(passes[0]),
            last: i64::from(passes[passes.len() - 1]),
        }),
        None => Ok(()),
    }
}
