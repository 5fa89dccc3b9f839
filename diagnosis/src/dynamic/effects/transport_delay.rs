//! Transport delay of the drive: a pure delay between the recorded drive and the force: a bus, a sampled controller.

use super::{DynamicEffect, FASTER, Facts, Part, Physics, Scale, TRANSPORT_DELAY, amount};
use crate::dynamic::number::Number;

/// w(t) = u(t − T); T in s
///
/// Source: Åström & Wittenmark, Computer-Controlled Systems (1997), section 2.3.
pub struct TransportDelay;

impl<T: Number> Physics<T> for TransportDelay {}

impl DynamicEffect for TransportDelay {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: TRANSPORT_DELAY,
                title: "Transport delay of the drive",
                variable: "frequency_hz",
                confused_with: &["drive_lag", "sensor_lag"],
                part: Part::Delay,
                parameters: &[amount("delay_s", "s")],
                experiment: FASTER,
                ..Facts::USUAL
            }
        }
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
