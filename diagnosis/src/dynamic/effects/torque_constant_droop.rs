//! Droop of the torque constant: a motor whose force per current falls where its coil leaves the magnet.

use super::{DynamicEffect, Facts, Flow, Physics, amount};
use crate::dynamic::number::Number;

/// gain (1 − δ x²); δ in 1/p²
///
/// Source: Clarke, Mirror-scanner actuators, in Handbook of Optical and Laser Scanning (2004).
pub struct TorqueConstantDroop;

impl<T: Number> Physics<T> for TorqueConstantDroop {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - *flow.gain * *flow.drive * parameters[0] * x * x;
    }
}

impl DynamicEffect for TorqueConstantDroop {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: "torque_constant_droop",
                title: "Droop of the torque constant",
                variable: "drive",
                confused_with: &["cubic_stiffness"],
                parameters: &[amount("droop", "1/p²")],
                by_gain: true,
                ..Facts::USUAL
            }
        }
    }
}
