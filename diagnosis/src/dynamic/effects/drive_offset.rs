//! Offset of the drive: an offset of the amplifier, or a constant force.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// w = u + o; o in u
pub struct DriveOffset;

impl<T: Number> Physics<T> for DriveOffset {
    #[inline(always)]
    fn drive(&self, parameters: &[T], drive: &mut T) {
        *drive += parameters[0];
    }
}

impl DynamicEffect for DriveOffset {
    fn id(&self) -> &'static str {
        "drive_offset"
    }
    fn title(&self) -> &'static str {
        "Offset of the drive"
    }
    fn formula(&self) -> &'static str {
        "w = u + o; o in u"
    }
    fn source(&self) -> &'static str {
        "Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["sensor_offset", "quadratic_stiffness"]
    }
    fn variable(&self) -> &'static str {
        "drive"
    }
    fn part(&self) -> Part {
        Part::Drive
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("offset", "u")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
