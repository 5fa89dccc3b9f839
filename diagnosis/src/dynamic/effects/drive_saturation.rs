//! Saturation of the drive: an amplifier at its limit.

use super::{DynamicEffect, Facts, Part, Physics, Scale, shape};
use crate::numerics::Number;

/// w = u within ±limit; limit in u
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub struct DriveSaturation;

impl<T: Number> Physics<T> for DriveSaturation {
    #[inline(always)]
    fn drive(&self, parameters: &[T], drive: &mut T) {
        *drive = drive.clamp(parameters[0]);
    }
}

impl DynamicEffect for DriveSaturation {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "drive_saturation",
                title: "Saturation of the drive",
                variable: "drive",
                confused_with: &["torque_constant_droop"],
                part: Part::Drive,
                parameters: &[shape("limit", "u")],
                ..Facts::USUAL
            }
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.95, 0.85, 0.7, 0.5].iter().map(|part| vec![part * scale.drive]).collect()
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        parameters[0] < scale.drive
    }
}
