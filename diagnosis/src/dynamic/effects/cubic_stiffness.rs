//! Cubic stiffness: a flexure or spring that hardens (or softens) with the cube of the deflection (Duffing).

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// x″ −= c x³; c in 1/(p² s²)
pub struct CubicStiffness;

impl<T: Number> Physics<T> for CubicStiffness {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let x = *flow.position;
        *flow.acceleration = *flow.acceleration - parameters[0] * x * x * x;
    }
}

impl DynamicEffect for CubicStiffness {
    fn id(&self) -> &'static str {
        "cubic_stiffness"
    }
    fn title(&self) -> &'static str {
        "Cubic stiffness"
    }
    fn formula(&self) -> &'static str {
        "x″ −= c x³; c in 1/(p² s²)"
    }
    fn source(&self) -> &'static str {
        "G. Duffing (1918); Kovacic & Brennan, The Duffing Equation (2011)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["torque_constant_droop", "quadratic_stiffness"]
    }
    fn variable(&self) -> &'static str {
        "position"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("coefficient", "1/(p²s²)")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
}
