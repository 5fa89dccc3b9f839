//! Lag of the drive: an amplifier or a coil of finite bandwidth: first-order lag of the force.

use super::{DRIVE_LAG, DynamicEffect, FASTER, Facts, Part, Physics, Scale, shape};
use crate::dynamic::number::Number;

/// τ w′ = u − w; τ in s
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub struct DriveLag;

impl<T: Number> Physics<T> for DriveLag {}

impl DynamicEffect for DriveLag {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: DRIVE_LAG,
                title: "Lag of the drive",
                variable: "frequency_hz",
                confused_with: &["transport_delay", "sensor_lag"],
                part: Part::DriveLag,
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
