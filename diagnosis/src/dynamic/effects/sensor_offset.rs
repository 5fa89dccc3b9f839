//! Offset of the read-out: an offset of the sensor.

use super::{DynamicEffect, Facts, MEAN_POSITIONS, Part, Physics, SENSOR_OFFSET, amount};
use crate::dynamic::number::Number;

/// y = x + o; o in p
///
/// Source: Fraden, Handbook of Modern Sensors (2016).
pub struct SensorOffset;

impl<T: Number> Physics<T> for SensorOffset {}

impl DynamicEffect for SensorOffset {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: SENSOR_OFFSET,
                title: "Offset of the read-out",
                variable: "position",
                confused_with: &["drive_offset", "quadratic_stiffness"],
                part: Part::SensorOffset,
                parameters: &[amount("offset", "p")],
                experiment: MEAN_POSITIONS,
                ..Facts::USUAL
            }
        }
    }
}
