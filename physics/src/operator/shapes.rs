//! Shapes over a quantity: a slope from a threshold on, a bump, a step.

use super::elementary::Elementary;
use super::{Form, Operation};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};
use crate::unit::Unit;

/// A pure number of quantities of one unit.
fn pure_of_common(of: &[Quantity]) -> Result<Agreed, UnitError> {
    common(of).map(|(_, factors)| (Quantity::Of(Unit::one()), factors))
}

pub static HINGE: Elementary = Elementary {
    form: Form::new(Operation::Hinge, "hinge", "hinge(e, at), which is max(0, e - at)", 2..=2),
    unit: common,
    interval: |of| {
        Ok(Interval { from: (of[0].from - of[1].to).max(0.0), to: (of[0].to - of[1].from).max(0.0) })
    },
    at: |x| if x[0] > x[1] { x[0] - x[1] } else { 0.0 },
    slopes: |x, slopes| slopes[..2].copy_from_slice(if x[0] > x[1] { &[1.0, -1.0] } else { &[0.0, 0.0] }),
};

pub static BUMP: Elementary = Elementary {
    form: Form::new(
        Operation::Bump,
        "bump",
        "bump(e, centre, width), which is exp(-((e - centre)/width)^2/2)",
        3..=3,
    ),
    unit: pure_of_common,
    interval: |of| match of[2].holds(0.0) {
        true => Err(format!("the width of a bump runs from {} to {}, and can be zero", of[2].from, of[2].to)),
        false => Ok(Interval { from: 0.0, to: 1.0 }),
    },
    at: |x| (-0.5 * ((x[0] - x[1]) / x[2]).powi(2)).exp(),
    slopes: |x, slopes| {
        let away = (x[0] - x[1]) / x[2];
        let slope = -(-0.5 * away * away).exp() * away / x[2];
        slopes[..3].copy_from_slice(&[slope, -slope, -slope * away]);
    },
};

pub static STEP: Elementary = Elementary {
    form: Form::new(
        Operation::Step,
        "step",
        "step(e, at), which is 1 where e is at or beyond it, else 0",
        2..=2,
    ),
    unit: pure_of_common,
    interval: |_| Ok(Interval { from: 0.0, to: 1.0 }),
    at: |x| if x[0] >= x[1] { 1.0 } else { 0.0 },
    slopes: |_, slopes| slopes[..2].fill(0.0),
};
