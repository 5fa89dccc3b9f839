//! Transport delay of the drive: a pure delay between the recorded drive and the force: a bus, a sampled controller.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// w(t) = u(t − T); T in s
pub struct TransportDelay;

impl<T: Number> Physics<T> for TransportDelay {}

impl DynamicEffect for TransportDelay {
    fn id(&self) -> &'static str {
        "transport_delay"
    }
    fn title(&self) -> &'static str {
        "Transport delay of the drive"
    }
    fn formula(&self) -> &'static str {
        "w(t) = u(t − T); T in s"
    }
    fn source(&self) -> &'static str {
        "Åström & Wittenmark, Computer-Controlled Systems (1997), section 2.3"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["drive_lag", "sensor_lag"]
    }
    fn variable(&self) -> &'static str {
        "frequency_hz"
    }
    fn part(&self) -> Part {
        Part::Delay
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("delay_s", "s")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
