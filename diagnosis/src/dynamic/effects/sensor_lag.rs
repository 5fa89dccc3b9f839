//! Lag of the read-out: a sensor or filter of finite bandwidth: first-order lag of the reading.

use super::{DynamicEffect, FASTER, Facts, Part, Physics, Scale, shape};
use crate::dynamic::number::Number;

/// τ y′ = x − y; τ in s
///
/// Source: Fraden, Handbook of Modern Sensors (2016).
pub struct SensorLag;

impl<T: Number> Physics<T> for SensorLag {}

impl DynamicEffect for SensorLag {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: "sensor_lag",
                title: "Lag of the read-out",
                variable: "frequency_hz",
                confused_with: &["drive_lag", "transport_delay"],
                part: Part::SensorLag,
                parameters: &[shape("time_constant_s", "s")],
                experiment: FASTER,
                ..Facts::USUAL
            }
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.2, 1.0, 4.0].iter().map(|part| vec![part * scale.step_s]).collect()
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
