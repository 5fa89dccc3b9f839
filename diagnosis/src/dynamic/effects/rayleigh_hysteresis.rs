//! Hysteresis after Rayleigh: domains of a piezo, or of iron at low fields, switch at thresholds of equal
//! density, so that gain and loss grow with the amplitude of the drive.

use super::{DynamicEffect, Facts, Part, Physics, RAYLEIGH_HYSTERESIS, amount};
use crate::dynamic::number::Number;

/// w = u + c R(u), R = R_r + ½(u − u_r)|u − u_r| from every reversal, u|u| from rest; c in 1/u
///
/// Source: Lord Rayleigh, Phil. Mag. 23 (1887) 225; Damjanovic, J. Appl. Phys. 82 (1997) 1788 (piezo).
pub struct RayleighHysteresis;

impl<T: Number> Physics<T> for RayleighHysteresis {}

impl DynamicEffect for RayleighHysteresis {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: RAYLEIGH_HYSTERESIS,
                title: "Hysteresis of the actuator (Rayleigh)",
                variable: "history",
                confused_with: &["drive_saturation", "bouc_wen_hysteresis", "coulomb_friction"],
                part: Part::DriveMemory,
                parameters: &[amount("coefficient", "1/u")],
                ..Facts::USUAL
            }
        }
    }
}
