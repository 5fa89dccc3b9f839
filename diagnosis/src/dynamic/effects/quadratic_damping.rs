//! Quadratic damping: drag of a turbulent fluid, with the square of the speed.

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// x″ −= c v |v|; c in 1/p
pub struct QuadraticDamping;

impl<T: Number> Physics<T> for QuadraticDamping {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let v = *flow.velocity;
        *flow.acceleration = *flow.acceleration - parameters[0] * v * v.abs();
    }
}

impl DynamicEffect for QuadraticDamping {
    fn id(&self) -> &'static str {
        "quadratic_damping"
    }
    fn title(&self) -> &'static str {
        "Quadratic damping"
    }
    fn formula(&self) -> &'static str {
        "x″ −= c v |v|; c in 1/p"
    }
    fn source(&self) -> &'static str {
        "Morison et al. (1950); Nayfeh & Mook, Nonlinear Oscillations (1979), section 3.3"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["coulomb_friction", "nonlinear_damping"]
    }
    fn variable(&self) -> &'static str {
        "velocity"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("coefficient", "1/p")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
