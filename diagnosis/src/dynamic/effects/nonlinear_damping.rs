//! Damping that grows with the deflection: damping that depends on the square of the deflection (van der Pol; squeeze film, eddy currents).

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// x″ −= c x² v; c in 1/(p² s)
pub struct NonlinearDamping;

impl<T: Number> Physics<T> for NonlinearDamping {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - parameters[0] * x * x * *flow.velocity;
    }
}

impl DynamicEffect for NonlinearDamping {
    fn id(&self) -> &'static str {
        "nonlinear_damping"
    }
    fn title(&self) -> &'static str {
        "Damping that grows with the deflection"
    }
    fn formula(&self) -> &'static str {
        "x″ −= c x² v; c in 1/(p² s)"
    }
    fn source(&self) -> &'static str {
        "B. van der Pol (1926); Lifshitz & Cross, Nonlinear Dynamics of Nanomechanical Resonators (2008)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["quadratic_damping"]
    }
    fn variable(&self) -> &'static str {
        "velocity"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("coefficient", "1/(p²s)")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
