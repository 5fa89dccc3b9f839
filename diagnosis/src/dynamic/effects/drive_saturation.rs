//! Saturation of the drive: an amplifier at its limit.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, shape};
use crate::dynamic::number::Number;

/// w = u within ±limit; limit in u
pub struct DriveSaturation;

impl<T: Number> Physics<T> for DriveSaturation {
    #[inline(always)]
    fn drive(&self, parameters: &[T], drive: &mut T) {
        *drive = drive.clamp(parameters[0]);
    }
}

impl DynamicEffect for DriveSaturation {
    fn id(&self) -> &'static str {
        "drive_saturation"
    }
    fn title(&self) -> &'static str {
        "Saturation of the drive"
    }
    fn formula(&self) -> &'static str {
        "w = u within ±limit; limit in u"
    }
    fn source(&self) -> &'static str {
        "Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["torque_constant_droop"]
    }
    fn variable(&self) -> &'static str {
        "drive"
    }
    fn part(&self) -> Part {
        Part::Drive
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[shape("limit", "u")] }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.95, 0.85, 0.7, 0.5].iter().map(|part| vec![part * scale.drive]).collect()
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        parameters[0] < scale.drive
    }
}
