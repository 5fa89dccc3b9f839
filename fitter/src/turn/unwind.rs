//! The wrap-around of the reading and of its reference: found in both columns and unwound, or refused with the row
//! that cannot be right.

use super::Wraps;
use super::arc::{Arc, densest, hull, within, wrapped};
use super::travelled::jumps;
use crate::fit::FitError;
use crate::recording::Recording;
use crate::statistics::ends;

/// Readings of a turning sensor against their reference, every one on the right turn.
pub(crate) struct Unwound {
    /// Where the readings' turn begins.
    pub from: f64,
    pub counts_turns: bool,
    pub wraps: Wraps,
    /// Reading within the turn from `from`.
    pub reading: Vec<f64>,
    /// Reading − reference, of neighbouring turns the nearest to the others' errors.
    pub error: Vec<f64>,
    /// The reference, continuous from row to row where it moves by less than half a turn.
    pub reference: Vec<f64>,
    /// Whether the readings cover the whole turn.
    pub whole: bool,
}

/// Errors may fill so much of a turn together; more is no error of an encoder.
const WIDEST: f64 = 0.25;
/// Of the rows that are right, this part at least stands within [`DENSE`] of a turn.
const SHARE: f64 = 0.8;
const DENSE: f64 = 0.125;
/// A gap in the readings above this part of a turn leaves the turn open, unless all gaps are as wide.
const OPEN: f64 = 0.125;

/// Unwinds a recording of a sensor that turns; `unit` is that of both columns and of `turn`.
///
/// # Errors
/// [`FitError::TurnRow`] for a row that is on no turn, [`FitError::Sense`] where the columns run in opposite
/// senses, [`FitError::TurnUnit`] where a column or `revolution` looks like another unit, and
/// [`FitError::TurnUnrelated`] where nothing of that kind explains the columns.
pub(crate) fn unwind(
    recording: &Recording,
    measured: &[f64],
    reference: &[f64],
    turn: f64,
    unit: &str,
) -> Result<Unwound, FitError> {
    let difference: Vec<f64> = measured.iter().zip(reference).map(|(m, r)| m - r).collect();
    check_jumps(recording, &[("measured", measured), ("reference", reference)], turn, unit)?;
    let arc = hull(&difference, turn);
    if arc.length > WIDEST * turn {
        return Err(explain(recording, measured, reference, &difference, turn, unit));
    }
    let middle = wrapped(arc.middle(), turn);
    let error: Vec<f64> = difference.iter().map(|e| middle + wrapped(e - middle, turn)).collect();
    let counted = |from: f64| measured.iter().all(|m| (from..=from + turn).contains(m));
    let (mut from, counts_turns) = match (counted(0.0), counted(-0.5 * turn)) {
        (true, _) => (0.0, false),
        (_, true) => (-0.5 * turn, false),
        // Noise may carry a wrapping reading over the end of its turn.
        _ => (0.0, !jumps(measured, turn)),
    };
    let covered = hull(measured, turn);
    let whole = !open(measured, covered, turn);
    if !whole && !counts_turns {
        // The arc must not be cut where the counter starts again.
        let beginning = from + within(covered.from - from, turn);
        if beginning + covered.length > from + turn {
            from = beginning - 0.5 * (turn - covered.length);
        }
    } else if !whole {
        from = covered.from - 0.5 * (turn - covered.length);
    }
    Ok(Unwound {
        from,
        counts_turns,
        wraps: Wraps { measured: wraps(measured, turn), reference: wraps(reference, turn) },
        reading: measured.iter().map(|m| from + within(m - from, turn)).collect(),
        error,
        reference: continuous(reference, turn),
        whole,
    })
}

/// Steps of more than half a turn from row to row.
fn wraps(values: &[f64], turn: f64) -> usize {
    values.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > 0.5 * turn).count()
}

fn continuous(values: &[f64], turn: f64) -> Vec<f64> {
    let mut now = values[0];
    let mut result = Vec::with_capacity(values.len());
    result.push(now);
    for pair in values.windows(2) {
        now += wrapped(pair[1] - pair[0], turn);
        result.push(now);
    }
    result
}

/// Whether a part of the turn was not read: a gap that is wide, and wider than the others.
fn open(measured: &[f64], covered: Arc, turn: f64) -> bool {
    let gap = turn - covered.length;
    if gap <= OPEN * turn {
        return false;
    }
    let mut sorted: Vec<f64> = measured.iter().map(|m| within(*m, turn)).collect();
    sorted.sort_by(f64::total_cmp);
    let mut steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // Repeated readings of one position are no steps.
    steps.retain(|step| *step > 1e-3 * turn);
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).is_none_or(|typical| gap > 2.5 * typical)
}

/// Turns that people count in, in their unit.
fn known_turns() -> Vec<(f64, String)> {
    let mut turns = vec![
        (1.0, "turns (one turn is 1)".to_string()),
        (std::f64::consts::TAU, "radians (one turn is 6.2832)".to_string()),
        (360.0, "degrees (one turn is 360)".to_string()),
        (400.0, "gradians (one turn is 400)".to_string()),
        (360e3, "millidegrees (one turn is 360 000)".to_string()),
        (21_600.0, "arcminutes (one turn is 21 600)".to_string()),
        (1_296_000.0, "arcseconds (one turn is 1 296 000)".to_string()),
    ];
    turns.extend((8..=24).map(|bits| {
        let counts = f64::from(1u32 << bits);
        (counts, format!("counts of {bits} bits (one turn is {counts})"))
    }));
    turns
}

/// A step back by nearly a whole turn of another unit than the stated one: the counter wrapped there, and not by
/// `revolution`.
fn check_jumps(
    recording: &Recording,
    columns: &[(&'static str, &[f64]); 2],
    turn: f64,
    unit: &str,
) -> Result<(), FitError> {
    for (index, (column, values)) in columns.iter().enumerate() {
        let other = columns[1 - index].1;
        let mut steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        steps.sort_by(f64::total_cmp);
        let typical = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        let (smallest, largest) = ends(values.iter().copied());
        for row in 1..values.len() {
            let step = values[row] - values[row - 1];
            let jump = step.abs();
            // The counter goes on after the wrap as it came: the jump misses its turn by a step or so.
            let near = |known: f64| (jump + typical - known).abs() <= 2.0 * typical + 1e-9 * known;
            if recording.pass[row] != recording.pass[row - 1]
                || jump < 20.0 * typical
                || jump < 0.9 * (largest - smallest)
            {
                continue;
            }
            let multiple = (jump / turn).round();
            if multiple >= 1.0 && (jump + typical - multiple * turn).abs() <= 0.02 * turn + 2.0 * typical {
                continue;
            }
            // A jump that the other column makes too is a move, unless it is as long as only a counter's is.
            let apart = wrapped(step - (other[row] - other[row - 1]), turn).abs();
            let moved = apart <= 2.0 * typical + 0.02 * turn;
            if let Some((_, looks)) =
                known_turns().into_iter().find(|(known, _)| near(*known) && (!moved || *known >= 1000.0))
            {
                return Err(FitError::TurnJump {
                    file: recording.file.clone(),
                    line: recording.line(row),
                    column,
                    from: values[row - 1],
                    to: values[row],
                    turn: format!("{turn} {unit}"),
                    looks,
                });
            }
        }
    }
    Ok(())
}

/// Why errors fill more of the turn than errors do.
fn explain(
    recording: &Recording,
    measured: &[f64],
    reference: &[f64],
    difference: &[f64],
    turn: f64,
    unit: &str,
) -> FitError {
    let rows = difference.len();
    let most = |count: usize| count as f64 >= SHARE * rows as f64;
    let (dense, count) = densest(difference, turn, DENSE * turn);
    let file = || recording.file.clone();
    if most(count) {
        let wrong: Vec<usize> = (0..rows).filter(|row| !dense.holds(difference[*row], turn)).collect();
        let centre = wrapped(dense.middle(), turn);
        let right = (0..rows).filter(|row| dense.holds(difference[*row], turn));
        let error = |row: usize| centre + wrapped(difference[row] - centre, turn);
        let (low, high) = ends(right.map(error));
        let row = wrong[0];
        return FitError::TurnRow {
            file: file(),
            line: recording.line(row),
            measured: measured[row],
            reference: reference[row],
            apart: error(row),
            low,
            high,
            unit: unit.to_string(),
            others: wrong.len() - 1,
        };
    }
    let concentrated = |value: &dyn Fn(usize) -> f64, turn: f64| {
        let values: Vec<f64> = (0..rows).map(value).collect();
        most(densest(&values, turn, DENSE * turn).1)
    };
    if concentrated(&|row| measured[row] + reference[row], turn) {
        return FitError::Sense {
            file: file(),
            column: "reference".to_string(),
            slope: -1.0,
            against: "`measured`",
            mend: "turn the sign of one of the two columns",
        };
    }
    let looks = |column: &'static str, looks: String| FitError::TurnUnit {
        file: file(),
        column,
        looks,
        revolution: turn,
        unit: unit.to_string(),
    };
    let (low, high) = ends(measured.iter().copied());
    for (known, name) in known_turns() {
        let factor = turn / known;
        if (factor - 1.0).abs() < 1e-9 {
            continue;
        }
        if concentrated(&|row| measured[row] - factor * reference[row], turn) {
            return looks("reference", name);
        }
        if concentrated(&|row| factor * measured[row] - reference[row], turn) {
            return looks("measured", name);
        }
        if high - low > 0.5 * known && concentrated(&|row| difference[row], known) {
            return looks("measured` and `reference", name);
        }
    }
    FitError::TurnUnrelated { file: file(), revolution: turn, unit: unit.to_string() }
}
