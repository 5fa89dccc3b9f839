//! Checks of a dynamic recording that need more than one row.

use super::DynamicRecording;
use crate::dynamic::fault::DynamicError;
use crate::numerics::median;
use crate::thresholds::dynamic::recording::LEAST_ROWS;
use crate::thresholds::dynamic::recording::checks::{CUT_OFF_PART, CUT_OFF_ROWS};

/// The step, checked: every one may deviate by the rounding of the printed column, `resolution_s`.
pub(super) fn step(
    file: &str,
    t_s: &[f64],
    runs: &[std::ops::Range<usize>],
    lines: &[u64],
    resolution_s: f64,
) -> Result<f64, DynamicError> {
    let mut steps: Vec<f64> = Vec::with_capacity(t_s.len());
    for run in runs {
        for k in run.start + 1..run.end {
            if t_s[k] <= t_s[k - 1] && t_s[k] < t_s[k - 1] - resolution_s {
                return Err(DynamicError::TimeBackward {
                    file: file.into(),
                    line: lines[k],
                    found: t_s[k],
                    before: t_s[k - 1],
                });
            }
            steps.push(t_s[k] - t_s[k - 1]);
        }
    }
    if steps.is_empty() {
        return Err(DynamicError::TooShort {
            file: file.into(),
            run: 0,
            found: t_s.len(),
            least: LEAST_ROWS,
        });
    }
    let usual = median(&mut steps);
    for run in runs {
        for k in run.start + 1..run.end {
            let found = t_s[k] - t_s[k - 1];
            // Rounding of both times, and of the binary fractions.
            if (found - usual).abs() > 1.01 * resolution_s + 1e-6 * usual.abs() + 4e-16 * t_s[k].abs() {
                let what = if found > 1.5 * usual { "rows are missing" } else { "the steps are unequal" };
                return Err(DynamicError::Step {
                    file: file.into(),
                    line: lines[k],
                    found,
                    expected: usual,
                    what,
                });
            }
        }
    }
    // The mean over the longest run is free of the rounding of single steps.
    let longest = runs.iter().max_by_key(|r| r.len()).cloned().unwrap_or(0..t_s.len());
    Ok((t_s[longest.end - 1] - t_s[longest.start]) / (longest.len() - 1).max(1) as f64)
}

/// The checks of the columns.
pub(super) fn columns(
    recording: &DynamicRecording,
    names: &[Vec<String>; 2],
    lines: &[u64],
) -> Result<(), DynamicError> {
    let file = || recording.file.clone();
    let constant = |column: &[f64]| column.iter().all(|v| *v == column[0]);
    for (column, name) in recording.drives.iter().zip(&names[0]) {
        if constant(column) {
            return Err(DynamicError::ConstantDrive { file: file(), column: name.clone(), value: column[0] });
        }
    }
    for (column, name) in recording.positions.iter().zip(&names[1]) {
        if constant(column) {
            return Err(DynamicError::ConstantPosition {
                file: file(),
                column: name.clone(),
                value: column[0],
            });
        }
        if let Some((row, end, rows)) = cut_off(column) {
            return Err(DynamicError::Saturated {
                file: file(),
                line: lines[row],
                column: name.clone(),
                end,
                value: column[row],
                rows,
            });
        }
    }
    let first = recording.runs[0].len();
    for (run, number) in recording.runs.iter().zip(&recording.run_numbers) {
        if run.len() != first {
            return Err(DynamicError::RunLength {
                file: file(),
                run: *number,
                found: run.len(),
                first: recording.run_numbers[0],
                expected: first,
            });
        }
        if run.len() < LEAST_ROWS {
            return Err(DynamicError::TooShort {
                file: file(),
                run: *number,
                found: run.len(),
                least: LEAST_ROWS,
            });
        }
    }
    Ok(())
}

/// First row, end and number of rows at which a read-out is cut off: it stands at its extreme for several
/// rows in a row, again and again, and gets there at speed. (A mechanism that rests arrives slowly.)
fn cut_off(column: &[f64]) -> Option<(usize, &'static str, usize)> {
    let moves: f64 = column.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
    let speed = (moves / column.len() as f64).sqrt();
    for (end, extreme) in [
        ("largest", column.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
        ("smallest", column.iter().copied().fold(f64::INFINITY, f64::min)),
    ] {
        let (mut rows, mut first, mut k) = (0, None, 0);
        while k < column.len() {
            let length = column[k..].iter().take_while(|v| **v == extreme).count();
            let abrupt = k > 0 && (column[k] - column[k - 1]).abs() > 0.25 * speed;
            if length >= CUT_OFF_ROWS && abrupt {
                rows += length;
                first = first.or(Some(k));
            }
            k += length.max(1);
        }
        if let Some(first) = first
            && rows as f64 > CUT_OFF_PART * column.len() as f64
        {
            return Some((first, end, rows));
        }
    }
    None
}
