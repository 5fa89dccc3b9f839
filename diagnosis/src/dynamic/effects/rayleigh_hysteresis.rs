//! Hysteresis after Rayleigh: domains of a piezo, or of iron at low fields, switch at thresholds of equal
//! density, so that gain and loss grow with the amplitude of the drive.

use super::{DynamicEffect, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// w = u + c R(u), R = ½ (u − u_r)|u − u_r| + R_r from every reversal, u|u| from rest; c in 1/u
pub struct RayleighHysteresis;

impl<T: Number> Physics<T> for RayleighHysteresis {}

impl DynamicEffect for RayleighHysteresis {
    fn id(&self) -> &'static str {
        "rayleigh_hysteresis"
    }
    fn title(&self) -> &'static str {
        "Hysteresis of the actuator (Rayleigh)"
    }
    fn formula(&self) -> &'static str {
        "w = u + c R(u), R = R_r + ½(u − u_r)|u − u_r| from every reversal, u|u| from rest; c in 1/u"
    }
    fn source(&self) -> &'static str {
        "Lord Rayleigh, Phil. Mag. 23 (1887) 225; Damjanovic, J. Appl. Phys. 82 (1997) 1788 (piezo)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["drive_saturation", "bouc_wen_hysteresis", "coulomb_friction"]
    }
    fn variable(&self) -> &'static str {
        "history"
    }
    fn part(&self) -> Part {
        Part::DriveMemory
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("coefficient", "1/u")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
