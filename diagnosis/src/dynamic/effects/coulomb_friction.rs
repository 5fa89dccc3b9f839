//! Coulomb friction: dry friction of constant magnitude against the motion; it holds the mechanism where the other forces are smaller.

use super::{CREEP, DynamicEffect, Flow, Parameter, Part, Physics, Reading, Scale, amount, plain_readings};
use crate::dynamic::number::Number;
use crate::thresholds::dynamic::effects::HARD;

/// x″ −= F sign v; stuck where |force| ≤ F; F in p/s²
pub struct CoulombFriction;

impl<T: Number> Physics<T> for CoulombFriction {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        *flow.acceleration = *flow.acceleration - parameters[0] * flow.direction;
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
        const { &[amount("force_per_inertia", "p/s²"), CREEP] }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0, HARD * scale.speed]]
    }
    fn holds(&self, parameters: &[f64]) -> f64 {
        parameters[0].max(0.0)
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
    fn creep(&self) -> Option<usize> {
        Some(1)
    }
    fn readings(&self, parameters: &[f64]) -> Vec<Reading> {
        plain_readings(self.parameters(), parameters, 1)
    }
    fn parameters_from(&self, value: &dyn Fn(&str) -> Option<f64>) -> Option<Vec<f64>> {
        let creep = value(CREEP.name).unwrap_or(f64::MIN_POSITIVE);
        let named = self.parameters()[..1].iter().map(|p| value(p.name));
        named.chain([Some(creep)]).collect()
    }
}
