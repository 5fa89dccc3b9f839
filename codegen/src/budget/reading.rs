//! The budget of what corrects a function of the reading: a routine, a device's page, the axis of a machine.

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;
use fitter::terms::{Scope, Term};

use super::{Line, Parts, Step, model, tenths};
use crate::devices::structure::Shared;
use crate::extent::LeftOut;
use crate::input::Arity;
use crate::physics::{Further, FurtherEncoding, Physics};
use crate::quantity::Quantity;
use crate::routine::Routine;

/// Part of the range over which the slope is taken.
const SLOPE_OVER: f64 = 1e-5;

/// The budget of a routine; none where the file does not say what the recording showed, and where the range lies outside it.
pub fn of_routine(routine: &Routine, quantity: &Quantity, file: &Coefficients) -> Option<Budget> {
    if routine.line {
        return None;
    }
    let bound = &routine.design.bound;
    let output = quantity.in_bound_unit(bound.output);
    let step = step(routine.plan.resolution, routine.options.input.arity, quantity);
    let proved = [quantity.in_bound_unit(bound.total) - output, output];
    parts(file, quantity, &routine.physics, routine.range, proved, step).budget(file)
}

/// The budget of a device whose coefficients lie in a page, which is proved within `total`, in the result's unit.
pub(crate) fn of_page(shared: &Shared, total: f64, file: &Coefficients) -> Option<Budget> {
    let Shared { quantity, range, plan, options, .. } = shared;
    let out = |term| LeftOut::of(term, file, *range, "a page does not hold it", term.scope == Scope::Device);
    let physics = Physics { left_out: file.terms.iter().map(out).collect(), ..Physics::default() };
    let step = step(plan.resolution, options.input.arity, quantity);
    parts(file, quantity, &physics, *range, [quantity.in_bound_unit(total), 0.0], step).budget(file)
}

/// The budget of a machine's axis, of which a table corrects `terms` in either direction, proved within `bound`.
pub(crate) fn of_axis(
    file: &Coefficients,
    terms: Vec<Term>,
    left_out: Vec<LeftOut>,
    range: (f64, f64),
    bound: f64,
) -> Option<Budget> {
    let quantity = Quantity::of(&file.error_model());
    let either = ("direction".to_string(), FurtherEncoding::Q31);
    let direction = Further { observable: either.0, from: -1.0, to: 1.0, encoding: either.1 };
    let physics = Physics { terms, further: vec![direction], left_out, ..Physics::default() };
    let step = step(0.0, Arity::Reading, &quantity);
    let parts = parts(file, &quantity, &physics, range, [bound, 0.0], step);
    let lines = parts.places.iter().map(|line| Line { result: line.place, slope: 1.0, ..*line });
    Parts {
        subject: "where this machine goes to when it is commanded once, corrected".into(),
        place: ("position".into(), quantity.reading_unit.clone()),
        places: lines.collect(),
        zero_elsewhere: true,
        // The table is given the direction.
        further: Vec::new(),
        ..parts
    }
    .budget(file)
}

fn step(size: f64, arity: Arity, quantity: &Quantity) -> Step {
    Step { size, unit: quantity.reading_unit.clone(), difference: arity == Arity::Probes }
}

/// Of a function of the reading; `proved` is the bound without the rounding of the result, and that, in the bound's unit.
fn parts(
    file: &Coefficients,
    quantity: &Quantity,
    physics: &Physics,
    range: (f64, f64),
    proved: [f64; 2],
    step: Step,
) -> Parts {
    let (from, to) = range;
    let model = file.error_model();
    let corrected = |reading: f64| model.corrected(reading) * quantity.bound_units_per_unit;
    let over = SLOPE_OVER * (to - from);
    let slope = |reading: f64| (corrected(reading + over) - corrected(reading - over)) / (2.0 * over);
    let line = |at: &f64| Line { place: *at, reading: *at, result: corrected(*at), slope: slope(*at) };
    let readings = tenths(from, to);
    let points: Vec<f64> =
        file.statistics.iter().flat_map(|s| &s.points).map(|point| point.reading).collect();
    let known = |at: &[f64]| model::known(file, physics, quantity, range, at);
    Parts {
        subject: super::subject(file),
        unit: quantity.bound_unit.clone(),
        place: (quantity.reading.clone(), quantity.reading_unit.clone()),
        places: readings.iter().map(line).collect(),
        model: known(&readings).zip(known(&points)).map(|(a, b)| [a, b]),
        arithmetic: proved[0],
        output: proved[1],
        step,
        left_out: physics.left_out.clone(),
        direction: 0.0,
        further: physics.further.iter().map(|input| input.observable.clone()).collect(),
        shapes: physics.terms.iter().filter(|t| !t.operator.is_linear()).map(|t| t.effect.clone()).collect(),
        zero_elsewhere: false,
    }
}
