//! Cubic stiffness: a flexure or spring that hardens (or softens) with the cube of the deflection (Duffing).

use super::{CUBIC_STIFFNESS, DynamicEffect, Facts, Flow, Physics, amount};
use crate::dynamic::number::Number;

/// x″ −= c x³; c in 1/(p² s²)
///
/// Source: G. Duffing (1918); Kovacic & Brennan, The Duffing Equation (2011).
pub struct CubicStiffness;

impl<T: Number> Physics<T> for CubicStiffness {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - parameters[0] * x * x * x;
    }
}

impl DynamicEffect for CubicStiffness {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: CUBIC_STIFFNESS,
                title: "Cubic stiffness",
                variable: "position",
                confused_with: &["torque_constant_droop", "quadratic_stiffness"],
                parameters: &[amount("coefficient", "1/(p²s²)")],
                ..Facts::USUAL
            }
        }
    }
}
