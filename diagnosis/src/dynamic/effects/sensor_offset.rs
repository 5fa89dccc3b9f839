//! Offset of the read-out: an offset of the sensor.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// y = x + o; o in p
pub struct SensorOffset;

impl<T: Number> Physics<T> for SensorOffset {}

impl DynamicEffect for SensorOffset {
    fn id(&self) -> &'static str {
        "sensor_offset"
    }
    fn title(&self) -> &'static str {
        "Offset of the read-out"
    }
    fn formula(&self) -> &'static str {
        "y = x + o; o in p"
    }
    fn source(&self) -> &'static str {
        "Fraden, Handbook of Modern Sensors (2016)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["drive_offset", "quadratic_stiffness"]
    }
    fn variable(&self) -> &'static str {
        "position"
    }
    fn part(&self) -> Part {
        Part::SensorOffset
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("offset", "p")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
