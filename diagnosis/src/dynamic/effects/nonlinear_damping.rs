//! Damping that grows with the deflection: damping that depends on the square of the deflection (van der Pol; squeeze film, eddy currents).

use super::{DynamicEffect, Facts, Flow, Physics, amount};
use crate::dynamic::number::Number;

/// x″ −= c x² v; c in 1/(p² s)
///
/// Source: B. van der Pol (1926); Lifshitz & Cross, Nonlinear Dynamics of Nanomechanical Resonators (2008).
pub struct NonlinearDamping;

impl<T: Number> Physics<T> for NonlinearDamping {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - parameters[0] * x * x * *flow.velocity;
    }
}

impl DynamicEffect for NonlinearDamping {
    fn facts(&self) -> &'static Facts {
        const {
            &Facts {
                id: "nonlinear_damping",
                title: "Damping that grows with the deflection",
                variable: "velocity",
                confused_with: &["quadratic_damping"],
                parameters: &[amount("coefficient", "1/(p²s)")],
                ..Facts::USUAL
            }
        }
    }
}
