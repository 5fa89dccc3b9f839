//! Devices held against each other: whether they can share a routine, and over which range.

use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};

use super::{Device, DevicesError};
use crate::options::Options;
use crate::quantity::Quantity;
use crate::routine::RoutineError;

/// The model of a device, held against the first's.
pub(super) fn model(device: &Device, first: &Device, options: &Options) -> Result<ErrorModel, DevicesError> {
    let differs = |what, found: String, expected: String| DevicesError::Structure {
        device: device.name.clone(),
        what,
        found,
        first: first.name.clone(),
        expected,
    };
    if device.coefficients.whole_turn() {
        return Err(DevicesError::WholeTurn { device: device.name.clone() });
    }
    let terms = &device.coefficients.terms;
    if let Some(term) = terms.iter().find(|term| !options.without.contains(&term.effect)) {
        return Err(DevicesError::Term { device: device.name.clone(), effect: term.effect.clone() });
    }
    match (&device.coefficients.sensor, &first.coefficients.sensor) {
        (
            Sensor::EddyCurrentPair { probe_distance_mm: found, .. },
            Sensor::EddyCurrentPair { probe_distance_mm: expected, .. },
        ) => {
            if found != expected {
                return Err(differs("probe_distance_mm", format!("{found}"), format!("{expected}")));
            }
        }
        (Sensor::Direct { unit: found, .. }, Sensor::Direct { unit: expected, .. }) => {
            if found != expected {
                return Err(differs("unit", format!("`{found}`"), format!("`{expected}`")));
            }
        }
        (found, expected) => {
            let kind = |sensor: &Sensor| match sensor {
                Sensor::EddyCurrentPair { .. } => "a pair of probes".to_string(),
                Sensor::Direct { .. } => "a direct sensor".to_string(),
            };
            return Err(differs("sensor", kind(found), kind(expected)));
        }
    }
    Ok(device.coefficients.error_model())
}

/// The range that all devices cover, or the one that is asked for.
pub(super) fn range(
    devices: &[Device],
    options: &Options,
    quantity: &Quantity,
) -> Result<(f64, f64), DevicesError> {
    let covered = |device: &Device| -> (f64, f64) {
        let Coefficients { valid_range, .. } = &device.coefficients;
        (valid_range.from, valid_range.to)
    };
    let reading_unit = quantity.reading_unit.clone();
    let Some((from, to)) = options.range else {
        let later = |a, b| if covered(b).0 > covered(a).0 { b } else { a };
        let sooner = |a, b| if covered(b).1 < covered(a).1 { b } else { a };
        let low = devices.iter().fold(&devices[0], later);
        let high = devices.iter().fold(&devices[0], sooner);
        let (from, to) = (covered(low).0, covered(high).1);
        if from < to {
            return Ok((from, to));
        }
        let (low, high) = (low.name.clone(), high.name.clone());
        return Err(DevicesError::Range { low, from, high, to, unit: reading_unit });
    };
    if !(from.is_finite() && to.is_finite() && from < to) {
        return Err(RoutineError::EmptyRange(from, to).into());
    }
    for device in devices {
        let (covered_from, covered_to) = covered(device);
        // Where the same commanded end settled a little further in, nothing is extrapolated.
        let covers = |reading| device.coefficients.valid_range.contains(reading);
        if !(options.extrapolate || (covers(from) && covers(to))) {
            let name = device.name.clone();
            return Err(DevicesError::BeyondRecording {
                name,
                from,
                to,
                covered_from,
                covered_to,
                unit: reading_unit,
            });
        }
    }
    Ok((from, to))
}
