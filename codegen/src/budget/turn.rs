//! The budget of an encoder's routine.

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;
use fitter::terms::Operator;

use super::{Line, Parts, Step, tenths};
use crate::turn::choose::TurnRoutine;
use crate::turn::describe::{known, uncorrected_direction};
use crate::turn::wraps::Wraps;

/// The budget of a routine; none where the file does not say what the recording showed.
pub(crate) fn of_turn(routine: &TurnRoutine, file: &Coefficients, wraps: &Wraps) -> Option<Budget> {
    let bound = routine.bound();
    let output = bound.min(0.5 * routine.unit_per_count);
    let step = routine.unit_per_count * f64::from(1u32 << routine.words.finer);
    parts(file, wraps, [bound - output, output], step)?.budget(file)
}

/// The budget of a table of other firmware, which is given counts of `step` and proved within `bound`.
pub(crate) fn of_ring(file: &Coefficients, wraps: &Wraps, bound: f64, step: f64) -> Option<Budget> {
    Parts { zero_elsewhere: true, ..parts(file, wraps, [bound, 0.0], step)? }.budget(file)
}

/// Of a whole turn; `proved` is the bound without the rounding of the result, and that.
fn parts(file: &Coefficients, wraps: &Wraps, proved: [f64; 2], step: f64) -> Option<Parts> {
    let unit = file.sensor.error_unit().to_string();
    let turn = file.turn.as_ref()?;
    let (direction, lags) = direction(file);
    // The harmonics are small beside the zero between the scales of sensor and reference.
    let line = |at: &f64| Line { place: *at, reading: at + wraps.zero, result: *at, slope: 1.0 };
    let positions = tenths(0.0, turn.revolution);
    let points: Vec<f64> =
        file.statistics.iter().flat_map(|s| &s.points).map(|point| point.reading - wraps.zero).collect();
    Some(Parts {
        subject: super::subject(file),
        place: ("corrected position".into(), unit.clone()),
        places: positions.iter().map(line).collect(),
        model: known(file, wraps, &positions).zip(known(file, wraps, &points)).map(|(a, b)| [a, b]),
        arithmetic: proved[0],
        output: proved[1],
        step: Step { size: step, unit: unit.clone(), difference: false },
        left_out: wraps.left_out.iter().filter(|out| !lags.contains(&&*out.effect)).cloned().collect(),
        direction,
        further: Vec::new(),
        shapes: Vec::new(),
        zero_elsewhere: false,
        unit,
    })
}

/// Half of what forward and backward differ by, at the recorded speed where it is most, and the effects that it holds: a
/// lag changes its sign with the direction, as play does, so that the two add up.
fn direction(file: &Coefficients) -> (f64, Vec<&str>) {
    let half = uncorrected_direction(file).unwrap_or(0.0);
    let speeds = file.turn.as_ref().and_then(|turn| turn.directions.speed_per_s);
    let Some(speeds) = speeds else { return (half.abs(), Vec::new()) };
    let lags = || {
        let first = |term: &'_ fitter::terms::Term| term.coefficients.first().copied().unwrap_or(0.0);
        let is_lag = |operator: &Operator| matches!(operator, Operator::Rate(_));
        file.terms.iter().filter(move |t| is_lag(&t.operator)).map(move |t| (t.effect.as_str(), first(t)))
    };
    let lag: f64 = lags().map(|(_, lag)| lag).sum();
    let largest = speeds.map(|speed| (half + lag * speed).abs()).into_iter().fold(0.0, f64::max);
    (largest, lags().map(|(effect, _)| effect).collect())
}
