//! Quadratic stiffness: a spring that is stiffer on one side.

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// x″ −= c x²; c in 1/(p s²)
pub struct QuadraticStiffness;

impl<T: Number> Physics<T> for QuadraticStiffness {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - parameters[0] * x * x;
    }
}

impl DynamicEffect for QuadraticStiffness {
    fn id(&self) -> &'static str {
        "quadratic_stiffness"
    }
    fn title(&self) -> &'static str {
        "Quadratic stiffness"
    }
    fn formula(&self) -> &'static str {
        "x″ −= c x²; c in 1/(p s²)"
    }
    fn source(&self) -> &'static str {
        "Nayfeh & Mook, Nonlinear Oscillations (1979), section 4.1"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["sensor_offset", "drive_offset", "cubic_stiffness"]
    }
    fn variable(&self) -> &'static str {
        "position"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("coefficient", "1/(p·s²)")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
