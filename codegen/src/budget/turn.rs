//! The budget of an encoder's routine.

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;

use super::{Parts, Step, tenths};
use crate::turn::choose::TurnRoutine;
use crate::turn::describe::{deviations, uncorrected_direction};
use crate::turn::wraps::Wraps;

/// The budget of a routine; none where the file does not say what the recording showed.
pub(crate) fn of_turn(routine: &TurnRoutine, file: &Coefficients, wraps: &Wraps) -> Option<Budget> {
    let unit = file.sensor.error_unit().to_string();
    let turn = file.turn.as_ref()?;
    let positions = tenths(0.0, turn.revolution);
    let points: Vec<f64> = file.statistics.iter().flat_map(|s| &s.points).map(|point| point.reading).collect();
    let bound = routine.bound();
    let output = bound.min(0.5 * routine.unit_per_count);
    let parts = Parts {
        place: format!("corrected position in {unit}"),
        places: positions.iter().map(|at| (*at, *at, 1.0)).collect(),
        deviations: deviations(file, wraps, &positions).zip(deviations(file, wraps, &points)).map(|(a, b)| [a, b]),
        arithmetic: bound - output,
        output,
        step: Step {
            size: routine.unit_per_count * f64::from(1u32 << routine.words.finer),
            unit: unit.clone(),
            difference: false,
        },
        left_out: &wraps.left_out,
        direction: uncorrected_direction(file).unwrap_or(0.0),
        unit,
    };
    parts.budget(file)
}
