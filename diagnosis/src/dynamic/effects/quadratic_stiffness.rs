//! Quadratic stiffness: a spring that is stiffer on one side.

use super::{DynamicEffect, Facts, Flow, MEAN_POSITIONS, Physics, amount};
use crate::dynamic::number::Number;

/// x″ −= c x²; c in 1/(p s²)
///
/// Source: Nayfeh & Mook, Nonlinear Oscillations (1979), section 4.1.
pub struct QuadraticStiffness;

impl<T: Number> Physics<T> for QuadraticStiffness {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - parameters[0] * x * x;
    }
}

impl DynamicEffect for QuadraticStiffness {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: "quadratic_stiffness",
                title: "Quadratic stiffness",
                variable: "position",
                confused_with: &["sensor_offset", "drive_offset", "cubic_stiffness"],
                parameters: &[amount("coefficient", "1/(p·s²)")],
                experiment: MEAN_POSITIONS,
                ..Facts::USUAL
            }
        }
    }
}
