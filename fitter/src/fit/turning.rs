//! Which recordings go the way of the turn: those of a sensor with a revolution, over a whole turn.

use super::{FitError, Options};
use crate::error_model::Sensor;
use crate::mirror::Mirror;
use crate::recording::{Readings, Recording};
use crate::turn::{self, Harmonics, Unwound};

/// The readings of a sensor that turns, unwound; none of another sensor, and none without a reference.
pub(super) fn unwound(recording: &Recording, sensor: &Sensor) -> Result<Option<Unwound>, FitError> {
    match (&recording.readings, sensor) {
        (
            Readings::Direct { measured, reference: Some(reference) },
            Sensor::Direct { unit, revolution: Some(turn) },
        ) => turn::unwind(recording, measured, reference, *turn, unit).map(Some),
        _ => Ok(None),
    }
}

/// The problem of a whole turn; none where a polynomial is to be fitted.
pub(super) fn around<'a>(
    recording: &'a Recording,
    mirror: &'a Mirror,
    options: &'a Options,
) -> Result<Option<Harmonics<'a>>, FitError> {
    let wrong =
        |option, found: usize, expected| Err(FitError::Option { option, found: found.to_string(), expected });
    let whole = unwound(recording, &mirror.sensor)?.filter(|unwound| unwound.whole);
    match (whole, options.order, options.harmonics) {
        (Some(_), Some(order), _) => {
            wrong("order", order, "harmonics for a sensor that turns (an order is a polynomial's)")
        }
        (None, _, Some(harmonics)) => wrong(
            "turn_harmonics",
            harmonics,
            "an order (harmonics need `revolution` and a whole turn of readings)",
        ),
        (Some(unwound), ..) => {
            Ok(Some(Harmonics::of(recording, mirror, options, unwound, turn_of(&mirror.sensor))))
        }
        (None, ..) => Ok(None),
    }
}

/// One revolution, where there is one.
pub(super) fn turn_of(sensor: &Sensor) -> f64 {
    sensor.revolution().unwrap_or(f64::INFINITY)
}
