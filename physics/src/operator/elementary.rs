//! Functions of mathematics.

use super::{Form, Operation, Operator};
use crate::evaluate::{Time, Value, pointwise};
use crate::interval::Interval;
use crate::quantity::{Agreed, Quantity, UnitError, common};
use crate::unit::Unit;

/// A function of the values of one row.
pub struct Elementary {
    pub(super) form: Form,
    pub(super) unit: fn(&[Quantity]) -> Result<Agreed, UnitError>,
    pub(super) interval: fn(&[Interval]) -> Result<Interval, String>,
    pub(super) at: fn(&[f64]) -> f64,
    /// Writes the derivatives by the arguments.
    pub(super) slopes: fn(&[f64], &mut [f64]),
}

impl Operator for Elementary {
    fn form(&self) -> &Form {
        &self.form
    }

    fn unit(&self, of: &[Quantity]) -> Result<Agreed, UnitError> {
        (self.unit)(of)
    }

    fn interval(&self, of: &[Interval]) -> Result<Interval, String> {
        (self.interval)(of)
    }

    fn value(&self, of: &[Value], _: &Time) -> Value {
        pointwise(of, self.at, self.slopes)
    }

    fn at(&self, x: &[f64], slopes: &mut [f64]) -> f64 {
        (self.slopes)(x, slopes);
        (self.at)(x)
    }
}

/// A pure number of a pure number.
fn pure(of: &[Quantity]) -> Result<Agreed, UnitError> {
    Ok((Quantity::Of(Unit::one()), vec![of[0].pure()?]))
}

/// A pure number of an angle, or of a pure number as one in radians.
fn of_angle(of: &[Quantity]) -> Result<Agreed, UnitError> {
    let unit = of[0].unit();
    let radian = Unit::named("rad");
    let factor = unit.in_units_of(&radian).or_else(|| unit.in_units_of(&Unit::one()));
    let factor = factor.ok_or(UnitError::Needs(unit, "an angle or a pure number"))?;
    Ok((Quantity::Of(Unit::one()), vec![factor]))
}

pub static ABS: Elementary = Elementary {
    form: Form::new(Operation::Abs, "abs", "abs(e)", 1..=1),
    unit: common,
    interval: |of| {
        let most = of[0].from.abs().max(of[0].to.abs());
        let least = if of[0].holds(0.0) { 0.0 } else { of[0].from.abs().min(of[0].to.abs()) };
        Ok(Interval { from: least, to: most })
    },
    at: |x| x[0].abs(),
    slopes: |x, slopes| slopes[0] = if x[0] < 0.0 { -1.0 } else { 1.0 },
};

pub static SIGN: Elementary = Elementary {
    form: Form::new(Operation::Sign, "sign", "sign(e)", 1..=1),
    unit: |_| Ok((Quantity::Of(Unit::one()), vec![1.0])),
    interval: |of| Ok(of[0].rising(sign)),
    at: |x| sign(x[0]),
    slopes: |_, slopes| slopes[0] = 0.0,
};

/// −1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

pub static MIN: Elementary = Elementary {
    form: Form::new(Operation::Min, "min", "min(a, b)", 2..=2),
    unit: common,
    interval: |of| Ok(Interval { from: of[0].from.min(of[1].from), to: of[0].to.min(of[1].to) }),
    at: |x| if x[0] <= x[1] { x[0] } else { x[1] },
    slopes: |x, slopes| slopes[..2].copy_from_slice(if x[0] <= x[1] { &[1.0, 0.0] } else { &[0.0, 1.0] }),
};

pub static MAX: Elementary = Elementary {
    form: Form::new(Operation::Max, "max", "max(a, b)", 2..=2),
    unit: common,
    interval: |of| Ok(Interval { from: of[0].from.max(of[1].from), to: of[0].to.max(of[1].to) }),
    at: |x| if x[0] >= x[1] { x[0] } else { x[1] },
    slopes: |x, slopes| slopes[..2].copy_from_slice(if x[0] >= x[1] { &[1.0, 0.0] } else { &[0.0, 1.0] }),
};

pub static SQRT: Elementary = Elementary {
    form: Form::new(Operation::Sqrt, "sqrt", "sqrt(e)", 1..=1),
    unit: |of| match &of[0] {
        Quantity::Number(_) => Ok((Quantity::Of(Unit::one()), vec![1.0])),
        Quantity::Of(unit) => Ok((Quantity::Of(unit.power(0.5).ok_or(UnitError::Exponent)?), vec![1.0])),
    },
    interval: |of| match of[0].from < 0.0 {
        true => Err(format!("a value down to {} has no square root", of[0].from)),
        false => Ok(of[0].rising(f64::sqrt)),
    },
    at: |x| x[0].sqrt(),
    // At zero the slope is infinite; a parameter moves nothing there that could be seen.
    slopes: |x, slopes| slopes[0] = if x[0] > 0.0 { 0.5 / x[0].sqrt() } else { 0.0 },
};

pub static EXP: Elementary = Elementary {
    form: Form::new(Operation::Exp, "exp", "exp(e)", 1..=1),
    unit: pure,
    interval: |of| Ok(of[0].rising(f64::exp)),
    at: |x| x[0].exp(),
    slopes: |x, slopes| slopes[0] = x[0].exp(),
};

pub static LOG: Elementary = Elementary {
    form: Form::new(Operation::Log, "log", "log(e)", 1..=1),
    unit: pure,
    interval: |of| match of[0].from <= 0.0 {
        true => Err(format!("a value down to {} has no logarithm", of[0].from)),
        false => Ok(of[0].rising(f64::ln)),
    },
    at: |x| x[0].ln(),
    slopes: |x, slopes| slopes[0] = 1.0 / x[0],
};

pub static SIN: Elementary = Elementary {
    form: Form::new(Operation::Sin, "sin", "sin(e)", 1..=1),
    unit: of_angle,
    interval: |of| Ok(of_wave(of[0], f64::sin, std::f64::consts::FRAC_PI_2)),
    at: |x| x[0].sin(),
    slopes: |x, slopes| slopes[0] = x[0].cos(),
};

pub static COS: Elementary = Elementary {
    form: Form::new(Operation::Cos, "cos", "cos(e)", 1..=1),
    unit: of_angle,
    interval: |of| Ok(of_wave(of[0], f64::cos, 0.0)),
    at: |x| x[0].cos(),
    slopes: |x, slopes| slopes[0] = -x[0].sin(),
};

/// The values of a wave with a crest at `crest`.
fn of_wave(of: Interval, wave: fn(f64) -> f64, crest: f64) -> Interval {
    use std::f64::consts::{PI, TAU};
    let holds = |place: f64| ((of.to - place) / TAU).floor() >= ((of.from - place) / TAU).ceil();
    let ends = [wave(of.from), wave(of.to)];
    Interval {
        from: if holds(crest + PI) { -1.0 } else { ends[0].min(ends[1]) },
        to: if holds(crest) { 1.0 } else { ends[0].max(ends[1]) },
    }
}

pub static TANH: Elementary = Elementary {
    form: Form::new(Operation::Tanh, "tanh", "tanh(e)", 1..=1),
    unit: pure,
    interval: |of| Ok(of[0].rising(f64::tanh)),
    at: |x| x[0].tanh(),
    slopes: |x, slopes| slopes[0] = 1.0 - x[0].tanh().powi(2),
};
