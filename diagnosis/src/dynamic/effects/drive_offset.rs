//! Offset of the drive: an offset of the amplifier, or a constant force.

use super::{DRIVE_OFFSET, DynamicEffect, Facts, MEAN_POSITIONS, Part, Physics, amount};
use crate::numerics::Number;

/// w = u + o; o in u
///
/// Source: Franklin, Powell & Workman, Digital Control of Dynamic Systems (1998).
pub struct DriveOffset;

impl<T: Number> Physics<T> for DriveOffset {
    #[inline(always)]
    fn drive(&self, parameters: &[T], drive: &mut T) {
        *drive += parameters[0];
    }
}

impl DynamicEffect for DriveOffset {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: DRIVE_OFFSET,
                title: "Offset of the drive",
                variable: "drive",
                confused_with: &["sensor_offset", "quadratic_stiffness"],
                part: Part::Drive,
                parameters: &[amount("offset", "u")],
                experiment: MEAN_POSITIONS,
                ..Facts::USUAL
            }
        }
    }
}
