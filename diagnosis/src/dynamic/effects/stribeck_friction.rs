//! Stribeck friction: dry friction that is larger at rest and falls with speed.

use super::{
    CREEP, DynamicEffect, Flow, Parameter, Part, Physics, Reading, Scale, amount, plain_readings, shape,
};
use crate::dynamic::number::Number;
use crate::thresholds::dynamic::effects::HARD;

/// x″ −= (F + E exp(−(v/v_s)²)) sign v; stuck where |force| ≤ F + E; F, E in p/s², v_s in p/s
pub struct StribeckFriction;

impl<T: Number> Physics<T> for StribeckFriction {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let relative = *flow.velocity / parameters[2];
        let friction = parameters[0] + parameters[1] * (-(relative * relative)).exp();
        *flow.acceleration = *flow.acceleration - friction * flow.direction;
    }
}

impl DynamicEffect for StribeckFriction {
    fn id(&self) -> &'static str {
        "stribeck_friction"
    }
    fn title(&self) -> &'static str {
        "Stribeck friction"
    }
    fn formula(&self) -> &'static str {
        "x″ −= (F + E exp(−(v/v_s)²)) sign v; stuck where |force| ≤ F + E; F, E in p/s², v_s in p/s"
    }
    fn source(&self) -> &'static str {
        "R. Stribeck (1902); Armstrong-Hélouvry et al., Automatica 30 (1994), Eq. 3"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["coulomb_friction", "bouc_wen_hysteresis"]
    }
    fn variable(&self) -> &'static str {
        "velocity"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const {
            &[
                amount("force_per_inertia", "p/s²"),
                amount("extra_static", "p/s²"),
                shape("stribeck_velocity", "p/s"),
                CREEP,
            ]
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.03, 0.1, 0.3, 1.0]
            .iter()
            .map(|part| vec![0.0, 0.0, part * scale.speed, HARD * scale.speed])
            .collect()
    }
    fn starts_from(&self, simpler: &str, parameters: &[f64], scale: &Scale) -> Vec<Vec<f64>> {
        match (simpler, parameters) {
            ("coulomb_friction", [force, creep]) => [0.1, 0.3, 1.0]
                .iter()
                .map(|part| vec![0.9 * force, 0.3 * force, part * scale.speed, *creep])
                .collect(),
            _ => Vec::new(),
        }
    }
    fn holds(&self, parameters: &[f64]) -> f64 {
        (parameters[0] + parameters[1]).max(0.0)
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        // Beyond the speeds of the recording the fall of the friction is a viscous damping.
        parameters[0] >= 0.0 && parameters[1] > 0.0 && parameters[2] < 3.0 * scale.speed
    }
    fn creep(&self) -> Option<usize> {
        Some(3)
    }
    fn readings(&self, parameters: &[f64]) -> Vec<Reading> {
        plain_readings(self.parameters(), parameters, 3)
    }
    fn parameters_from(&self, value: &dyn Fn(&str) -> Option<f64>) -> Option<Vec<f64>> {
        let creep = value(CREEP.name).unwrap_or(f64::MIN_POSITIVE);
        let named = self.parameters()[..3].iter().map(|p| value(p.name));
        named.chain([Some(creep)]).collect()
    }
}
