//! How large and how small the numbers of coefficients and options may be: far beyond any sensor on either side, and well
//! within what exact arithmetic on words of firmware can tell apart and ends with.

use crate::coefficients::Coefficients;
use crate::error_model::Sensor;
use crate::terms::{Operator, Term};

/// Smallest length, time, gain or other scale.
pub const SMALLEST: f64 = 1e-18;
/// Largest number of either sign.
pub const LARGEST: f64 = 1e18;
/// Width of a range as a part of its farther end, below which its readings are one number.
const NARROWEST: f64 = 1e-12;
/// How often a period may go into what the result covers, and how often that into the period: beyond, there is nothing
/// that repeats.
const PERIODS: (f64, f64) = (1e-6, 1e10);
/// Time constant as a multiple of the recorded time, beyond which it could not have been found.
const SLOWEST: f64 = 1e6;
/// The largest part of the correction as a multiple of the range of readings.
const LARGEST_PART: f64 = 1e12;

/// A number above zero that can be computed with.
///
/// # Errors
/// What was expected, to stand behind the number's name.
pub fn scale(value: f64) -> Result<(), String> {
    let fits = (SMALLEST..=LARGEST).contains(&value);
    fits.then_some(()).ok_or_else(|| format!("is {value:?}, expected {SMALLEST:e} to {LARGEST:e}"))
}

/// A number of either sign that can be computed with.
///
/// # Errors
/// As [`scale`].
pub fn place(value: f64) -> Result<(), String> {
    let fits = value.abs() <= LARGEST;
    fits.then_some(()).ok_or_else(|| format!("is {value:?}, expected -{LARGEST:e} to {LARGEST:e}"))
}

/// The ends of a range that can be computed with, `from` < `to`.
///
/// # Errors
/// As [`scale`].
pub fn range(from: f64, to: f64) -> Result<(), String> {
    place(from).and(place(to))?;
    scale(to - from).map_err(|reason| format!("has a width that {reason}"))?;
    let fits = to - from >= NARROWEST * from.abs().max(to.abs());
    fits.then_some(()).ok_or_else(|| format!("runs from {from:?} to {to:?}, which is one number"))
}

/// Whether all numbers of a model can be computed with.
///
/// # Errors
/// The field, what it holds and what was expected.
pub fn of_model(file: &Coefficients) -> Result<(), String> {
    let named =
        |name: &str, checked: Result<(), String>| checked.map_err(|reason| format!("`{name}` {reason}"));
    let (base, covered) = (&file.base, &file.valid_range);
    named("valid_range", range(covered.from, covered.to))?;
    match &file.sensor {
        Sensor::EddyCurrentPair { probe_distance_mm, initial_gap_mm } => {
            named("probe_distance_mm", scale(*probe_distance_mm))?;
            named("initial_gap_mm", scale(*initial_gap_mm))?;
        }
        Sensor::Direct { revolution, .. } => named("revolution", revolution.map_or(Ok(()), scale))?,
    }
    if let Some(turn) = &file.turn {
        named("turn.revolution", scale(turn.revolution))?;
        named("turn.from", place(turn.from))?;
    }
    named("base.centre", place(base.centre))?;
    let farthest = (covered.from - base.centre).abs().max((covered.to - base.centre).abs());
    let most = LARGEST_PART * (covered.to - covered.from);
    let part = |name: &str, coefficient: f64, power: i32| {
        let size = coefficient.abs() * farthest.powi(power);
        let reason =
            || format!("`{name}` adds {size:.1e} at the end of the range, expected {most:.1e} at most");
        (size <= most).then_some(()).ok_or_else(reason)
    };
    for (power, a) in (0..).zip(&base.coefficients) {
        part(&format!("base.coefficients[{power}]"), *a, power)?;
    }
    part("base.extrapolation.constant", base.extrapolation.constant, 0)?;
    part("base.extrapolation.slope", base.extrapolation.slope, 1)?;
    for (name, [from, to]) in &file.observed {
        named(&format!("observed.{name}"), place(*from).and(place(*to)))?;
    }
    for term in &file.terms {
        let of_term = |reason| format!("the term `{}` of {}: {reason}", term.operator.kind(), term.effect);
        of_one(term, file).map_err(of_term)?;
    }
    Ok(())
}

/// The numbers of one term.
fn of_one(term: &Term, file: &Coefficients) -> Result<(), String> {
    let scaled = |name: &str, value: f64| scale(value).map_err(|reason| format!("`{name}` {reason}"));
    let placed = |name: &str, value: f64| place(value).map_err(|reason| format!("`{name}` {reason}"));
    let begins = |initial: Option<f64>| initial.map_or(Ok(()), |value| placed("initial", value));
    term.coefficients.iter().try_for_each(|c| placed("coefficients", *c))?;
    match &term.operator {
        Operator::Product(product) => {
            product.factors.iter().try_for_each(|factor| placed("mean", factor.mean))
        }
        Operator::Play(play) => play.elements.iter().try_for_each(|element| {
            scaled("half_width", element.half_width)?;
            begins(element.initial)
        }),
        Operator::Lag(lag) => {
            let recorded = file.observed.get("t_s").map_or(LARGEST, |[from, to]| to - from);
            let slowest = SLOWEST * recorded;
            scaled("time_constant_s", lag.time_constant_s)?;
            if lag.time_constant_s > slowest {
                let found = lag.time_constant_s;
                return Err(format!("`time_constant_s` is {found:?}, expected {slowest:.1e} at most"));
            }
            placed("mean", lag.mean).and(begins(lag.initial))
        }
        Operator::Exponential(e) => scaled("scale", e.scale).and(placed("start", e.start)),
        Operator::Step(step) => placed("at", step.at),
        Operator::Periodic(periodic) => {
            let range = &file.valid_range;
            let unit = match file.sensor {
                Sensor::EddyCurrentPair { .. } => crate::units::ARCSEC_PER_RAD,
                Sensor::Direct { .. } => 1.0,
            };
            let covered = unit * (file.sensor.calculated(range.to) - file.sensor.calculated(range.from));
            let (shortest, longest) = (covered / PERIODS.1, covered / PERIODS.0);
            let period = periodic.period;
            let fits = (shortest..=longest).contains(&period);
            let expected = || format!("`period` is {period:?}, expected {shortest:.1e} to {longest:.1e}");
            fits.then_some(()).ok_or_else(expected)
        }
        Operator::Gaussian(gaussian) => {
            scaled("width", gaussian.width).and(placed("centre", gaussian.centre))
        }
        Operator::Hinge(hinge) => placed("threshold", hinge.threshold),
        Operator::Rate(_) => Ok(()),
        Operator::Expression(expression) => {
            expression.parameters.iter().try_for_each(|fixed| placed(&fixed.name, fixed.value))
        }
    }
}
