//! Shapes over a quantity: a slope from a threshold on, a bump, a step.

use super::elementary::Elementary;
use crate::interval::Interval;
use crate::quantity::{Quantity, UnitError, common};
use crate::unit::Unit;

/// A pure number of quantities of one unit.
fn pure_of_common(of: &[Quantity]) -> Result<(Quantity, Vec<f64>), UnitError> {
    common(of).map(|(_, factors)| (Quantity::Of(Unit::one()), factors))
}

pub static HINGE: Elementary = Elementary::of_one_unit(
    "hinge",
    "hinge(e, at), which is max(0, e - at)",
    2,
    common,
    |of| Ok(Interval { from: (of[0].from - of[1].to).max(0.0), to: (of[0].to - of[1].from).max(0.0) }),
    |x, slopes| {
        let beyond = x[0] > x[1];
        slopes[..2].copy_from_slice(if beyond { &[1.0, -1.0] } else { &[0.0, 0.0] });
        if beyond { x[0] - x[1] } else { 0.0 }
    },
);

pub static BUMP: Elementary = Elementary::of_one_unit(
    "bump",
    "bump(e, centre, width), which is exp(-((e - centre)/width)^2/2)",
    3,
    pure_of_common,
    |of| match of[2].holds(0.0) {
        true => Err(format!("the width of a bump runs from {} to {}, and can be zero", of[2].from, of[2].to)),
        false => Ok(Interval { from: 0.0, to: 1.0 }),
    },
    |x, slopes| {
        let away = (x[0] - x[1]) / x[2];
        let value = (-0.5 * away * away).exp();
        let slope = -value * away / x[2];
        slopes[..3].copy_from_slice(&[slope, -slope, -slope * away]);
        value
    },
);

pub static STEP: Elementary = Elementary::of_one_unit(
    "step",
    "step(e, at), which is 1 where e is at or beyond it, else 0",
    2,
    pure_of_common,
    |_| Ok(Interval { from: 0.0, to: 1.0 }),
    |x, slopes| {
        slopes[..2].fill(0.0);
        if x[0] >= x[1] { 1.0 } else { 0.0 }
    },
);
