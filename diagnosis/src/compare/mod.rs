//! What changed between two recordings: one device at two times, a healthy and a suspect one.
//!
//! Both are diagnosed. What was found in either, and the base, make one linear model of both recordings, in which each part
//! may be the same or differ; two names are one where one of them does for both recordings. Offsets, noise, and what happened
//! at one time belong to each recording by itself. The parts that differ are chosen one by one at a family-wise false-alarm
//! rate, and each must predict held-out rows better.

mod alternatives;
mod answer;
mod best_name;
mod changes;
mod choose;
mod design;
mod events;
mod joined;
pub mod motion;
mod names;
mod nearly;
mod pair;
mod proof;
mod quantity;
mod reference;
mod shared;
mod stepwise;

use fitter::{Mirror, Recording};
use numerics::parallel;

use crate::diagnosis::{Options, diagnose};
use crate::effects::catalogue;
use crate::error::DiagnosisError;
use crate::observe::observe;
use crate::screened::Screened;
use crate::thresholds::compare::LEAST_COMMON;

pub use answer::{Change, Compared, Comparison, HeldOut, Kind, Points, Side, Visible};
use nearly::take_forms_for_effects;
use pair::Pair;
pub use quantity::{Estimate, Quantity};

/// Compares two recordings of a device, or of two of one kind.
///
/// # Errors
/// [`DiagnosisError`] where one of them cannot be diagnosed, or where they have no common range.
pub fn compare(
    then: &Recording,
    now: &Recording,
    mirror: &Mirror,
    options: &Options,
) -> Result<Compared, DiagnosisError> {
    overlap(then, now, mirror, options)?;
    let (a, b) = parallel::join(
        || diagnose(then, mirror, None, None, options),
        || diagnose(now, mirror, None, None, options),
    );
    let mut outcomes = [a?, b?];
    let catalogue = [&catalogue(&mirror.sensor)[..], &options.declared].concat();
    let beyond = outcomes.each_mut().map(|outcome| take_forms_for_effects(outcome, &catalogue));
    Ok(Pair::new(&outcomes, beyond).compared(&catalogue))
}

/// Refuses recordings of different stretches, before they are diagnosed.
fn overlap(
    then: &Recording,
    now: &Recording,
    mirror: &Mirror,
    options: &Options,
) -> Result<(), DiagnosisError> {
    let rows = |recording| {
        let screened = Screened::of(recording, mirror, None, None)?;
        observe(screened.parts().0.recording, mirror, None, options.base)
    };
    let [before, after] = [rows(then)?, rows(now)?];
    let [(a, b), (c, d)] = [before.stroke(), after.stroke()];
    if b.min(d) - a.max(c) >= LEAST_COMMON * (b - a).min(d - c) {
        return Ok(());
    }
    let unit = &before.unit;
    Err(DiagnosisError::NoCommonRange {
        file: now.file.clone(),
        found: format!("{c:.4} to {d:.4} {unit}"),
        expected: format!("{a:.4} to {b:.4} {unit}"),
    })
}
