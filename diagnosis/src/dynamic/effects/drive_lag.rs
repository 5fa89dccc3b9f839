//! Lag of the drive: an amplifier or a coil of finite bandwidth: first-order lag of the force.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, shape};
use crate::dynamic::number::Number;

/// τ w′ = u − w; τ in s
pub struct DriveLag;

impl<T: Number> Physics<T> for DriveLag {}

impl DynamicEffect for DriveLag {
    fn id(&self) -> &'static str {
        "drive_lag"
    }
    fn title(&self) -> &'static str {
        "Lag of the drive"
    }
    fn formula(&self) -> &'static str {
        "τ w′ = u − w; τ in s"
    }
    fn source(&self) -> &'static str {
        "Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["transport_delay", "sensor_lag"]
    }
    fn variable(&self) -> &'static str {
        "frequency_hz"
    }
    fn part(&self) -> Part {
        Part::DriveLag
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
