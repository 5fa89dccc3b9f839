//! Quadratic damping: drag of a turbulent fluid, with the square of the speed.

use super::{DynamicEffect, Facts, Flow, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// x″ −= c v |v|; c in 1/p
///
/// Source: Morison et al. (1950); Nayfeh & Mook, Nonlinear Oscillations (1979), section 3.3.
pub struct QuadraticDamping;

impl<T: Number> Physics<T> for QuadraticDamping {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let v = *flow.velocity;
        *flow.acceleration = *flow.acceleration - parameters[0] * v * v.abs();
    }
}

impl DynamicEffect for QuadraticDamping {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: "quadratic_damping",
                title: "Quadratic damping",
                variable: "velocity",
                confused_with: &["coulomb_friction", "nonlinear_damping"],
                parameters: &[amount("coefficient", "1/p")],
                ..Facts::USUAL
            }
        }
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
