//! What is told of a recording and removes nothing: pauses, repeated times, stuck and saturated stretches, a coarse
//! resolution.

use super::limits;
use super::scale::{median, resolution, trimmed};
use crate::recording::Recording;
use crate::statistics::ends;

/// The findings, one sentence each.
pub fn notes(recording: &Recording) -> Vec<String> {
    let mut notes = times(recording);
    for (name, values) in recording.columns() {
        if !matches!(name, "t_s" | "command_deg") && values.len() >= limits::FEWEST_ROWS {
            notes.extend(column(recording, name, values));
        }
    }
    notes
}

fn times(recording: &Recording) -> Vec<String> {
    let t = &recording.time_s;
    let gaps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    let mut notes = Vec::new();
    if gaps.len() < limits::FEWEST_ROWS {
        return notes;
    }
    let repeated = gaps.iter().filter(|gap| **gap == 0.0).count();
    if repeated > 0 {
        let line = recording.line(gaps.iter().position(|gap| *gap == 0.0).unwrap_or(0) + 1);
        notes.push(format!("t_s: {repeated} rows have the time of the row before, the first in line {line}"));
    }
    let usual = median(&mut gaps.clone());
    let (at, longest) =
        gaps.iter().enumerate().fold((0, 0.0), |best, (k, gap)| if *gap > best.1 { (k, *gap) } else { best });
    if usual > 0.0 && longest > limits::GAP * usual && longest > 0.05 * (t[t.len() - 1] - t[0]) {
        let line = recording.line(at + 1);
        notes.push(format!(
            "t_s: a pause of {longest:.4} s before line {line}; rows are usually {usual:.4} s apart"
        ));
    }
    notes
}

fn column(recording: &Recording, name: &str, values: &[f64]) -> Vec<String> {
    let mut notes = Vec::new();
    let n = values.len();
    let changes = values.windows(2).filter(|w| w[0] != w[1]).count();
    let (mut longest, mut from, mut start) = (1, 0, 0);
    for k in 1..=n {
        if k == n || values[k] != values[start] {
            if k - start > longest {
                (longest, from) = (k - start, start);
            }
            start = k;
        }
    }
    // A reading of a sensor hardly ever repeats to the last digit unless nothing moves.
    if longest >= limits::STUCK_ROWS && 10 * changes > 9 * n {
        let (first, last) = (recording.line(from), recording.line(from + longest - 1));
        notes.push(format!(
            "{name}: stands at {} from line {first} to {last}, as if it were stuck",
            values[from]
        ));
    }
    let (low, high) = ends(values.iter().copied());
    for (end, extreme) in [("largest", high), ("smallest", low)] {
        let rows = values.iter().filter(|v| **v == extreme).count();
        let inside = values.iter().filter(|v| (**v - extreme).abs() < 0.02 * (high - low)).count();
        if 10 * changes > 7 * n
            && rows as f64 > limits::SATURATED * n as f64
            && 5 * rows > 4 * inside
            && values.windows(limits::CUT_OFF_ROWS).any(|rows| rows.iter().all(|v| *v == extreme))
        {
            notes.push(format!(
                "{name}: {rows} rows at its {end} value {extreme}, as if it were cut off there"
            ));
        }
    }
    let mut steps: Vec<f64> =
        values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| d.is_finite()).collect();
    let (step, scatter) = (resolution(values), trimmed(&mut steps));
    if step > 0.0 && high > low + 3.0 * step && step > limits::COARSE * scatter && scatter > 0.0 {
        notes.push(format!("{name}: comes in steps of {step:.3e}, coarser than its scatter"));
    }
    notes
}
