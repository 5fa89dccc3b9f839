//! Rows that are in the file twice, as a log that was joined from parts has them.

use std::cmp::Ordering;

use super::Fault;
use crate::recording::Recording;

/// Every row that repeats an earlier one in every column.
pub fn faults(recording: &Recording) -> Vec<Fault> {
    // Rows of different times differ.
    if recording.time_s.windows(2).all(|pair| pair[0] < pair[1]) {
        return Vec::new();
    }
    let columns = recording.columns();
    let compare = |a: &usize, b: &usize| {
        (columns.iter().map(|(_, values)| values[*a].total_cmp(&values[*b])))
            .chain([
                recording.pass[*a].cmp(&recording.pass[*b]),
                recording.direction[*a].cmp(&recording.direction[*b]),
            ])
            .find(|order| order.is_ne())
            .unwrap_or(Ordering::Equal)
    };
    let mut rows: Vec<usize> = (0..recording.rows()).collect();
    rows.sort_by(compare); // stable: equal rows stay in the order of the file
    let same = rows.chunk_by(|a, b| compare(a, b).is_eq());
    same.flat_map(|same| same[1..].iter().map(move |row| (same[0], *row)))
        .map(|(first, row)| {
            let reason = format!("the row repeats line {} in every column", recording.line(first));
            Fault::new(row, "t_s", recording.time_s[row], f64::INFINITY, reason)
        })
        .collect()
}
