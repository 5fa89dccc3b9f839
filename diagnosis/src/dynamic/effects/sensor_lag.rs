//! Lag of the read-out: a sensor or filter of finite bandwidth: first-order lag of the reading.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, shape};
use crate::dynamic::number::Number;

/// τ y′ = x − y; τ in s
pub struct SensorLag;

impl<T: Number> Physics<T> for SensorLag {}

impl DynamicEffect for SensorLag {
    fn id(&self) -> &'static str {
        "sensor_lag"
    }
    fn title(&self) -> &'static str {
        "Lag of the read-out"
    }
    fn formula(&self) -> &'static str {
        "τ y′ = x − y; τ in s"
    }
    fn source(&self) -> &'static str {
        "Fraden, Handbook of Modern Sensors (2016)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["drive_lag", "transport_delay"]
    }
    fn variable(&self) -> &'static str {
        "frequency_hz"
    }
    fn part(&self) -> Part {
        Part::SensorLag
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[shape("time_constant_s", "s")] }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.2, 1.0, 4.0].iter().map(|part| vec![part * scale.step_s]).collect()
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
