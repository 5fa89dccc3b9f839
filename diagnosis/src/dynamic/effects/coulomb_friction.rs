//! Coulomb friction: dry friction of constant magnitude against the motion; it holds the mechanism where the other forces are smaller.

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount};
use crate::dynamic::number::Number;

/// x″ −= F sign v; stuck where |force| ≤ F; F in p/s²
pub struct CoulombFriction;

impl<T: Number> Physics<T> for CoulombFriction {
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        flow.acceleration = flow.acceleration - parameters[0] * flow.direction;
    }
}

impl DynamicEffect for CoulombFriction {
    fn id(&self) -> &'static str {
        "coulomb_friction"
    }
    fn title(&self) -> &'static str {
        "Coulomb friction"
    }
    fn formula(&self) -> &'static str {
        "x″ −= F sign v; stuck where |force| ≤ F; F in p/s²"
    }
    fn source(&self) -> &'static str {
        "C. A. Coulomb (1785); Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["stribeck_friction", "bouc_wen_hysteresis", "quadratic_damping"]
    }
    fn variable(&self) -> &'static str {
        "velocity"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("force_per_inertia", "p/s²")] }
    }
    fn starts(&self, _: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn holds(&self, parameters: &[f64]) -> f64 {
        parameters[0].max(0.0)
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
