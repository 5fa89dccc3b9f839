//! Droop of the torque constant: a motor whose force per current falls where its coil leaves the magnet.

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// gain (1 − δ x²); δ in 1/p²
pub struct TorqueConstantDroop;

impl<T: Number> Physics<T> for TorqueConstantDroop {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - *flow.gain * *flow.drive * parameters[0] * x * x;
    }
}

impl DynamicEffect for TorqueConstantDroop {
    fn id(&self) -> &'static str {
        "torque_constant_droop"
    }
    fn title(&self) -> &'static str {
        "Droop of the torque constant"
    }
    fn formula(&self) -> &'static str {
        "gain (1 − δ x²); δ in 1/p²"
    }
    fn source(&self) -> &'static str {
        "Clarke, Mirror-scanner actuators, in Handbook of Optical and Laser Scanning (2004)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["cubic_stiffness"]
    }
    fn variable(&self) -> &'static str {
        "drive"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("droop", "1/p²")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
