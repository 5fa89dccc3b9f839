//! The budget of a routine of the reading.

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;

use super::{Line, Parts, Step, tenths};
use crate::estimate;
use crate::input::Arity;
use crate::quantity::Quantity;
use crate::routine::Routine;

/// Part of the range over which the slope is taken.
const SLOPE_OVER: f64 = 1e-5;

/// The budget of a routine; none where the file does not say what the recording showed, and where the range lies outside it.
pub fn of_routine(routine: &Routine, quantity: &Quantity, file: &Coefficients) -> Option<Budget> {
    if routine.line {
        return None;
    }
    let (from, to) = routine.range;
    let model = file.error_model();
    let corrected = |reading: f64| model.corrected(reading) * quantity.bound_units_per_unit;
    let step = SLOPE_OVER * (to - from);
    let slope = |reading: f64| (corrected(reading + step) - corrected(reading - step)) / (2.0 * step);
    let line = |at: &f64| Line { place: *at, reading: *at, result: corrected(*at), slope: slope(*at) };
    let readings = tenths(from, to);
    let points: Vec<f64> =
        file.statistics.iter().flat_map(|s| &s.points).map(|point| point.reading).collect();
    let deviations = |at: &[f64]| estimate::deviations(file, &routine.physics, quantity, routine.range, at);
    let bound = &routine.design.bound;
    let output = quantity.in_bound_unit(bound.output);
    let parts = Parts {
        unit: quantity.bound_unit.clone(),
        place: (quantity.reading.clone(), quantity.reading_unit.clone()),
        places: readings.iter().map(line).collect(),
        deviations: deviations(&readings).zip(deviations(&points)).map(|(a, b)| [a, b]),
        arithmetic: quantity.in_bound_unit(bound.total) - output,
        output,
        step: Step {
            size: routine.plan.resolution,
            unit: quantity.reading_unit.clone(),
            difference: routine.options.input.arity == Arity::Probes,
        },
        left_out: routine.physics.left_out.clone(),
        direction: 0.0,
    };
    parts.budget(file)
}
