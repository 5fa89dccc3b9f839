//! Stribeck friction: dry friction that is larger at rest and falls with speed.

use super::{CREEP, DynamicEffect, Facts, Flow, Physics, SLOW_TRIANGLES, Scale, amount, shape};
use crate::numerics::Number;
use crate::thresholds::dynamic::effects::HARD;

/// x″ −= (F + E exp(−(v/v_s)²)) sign v; stuck where |force| ≤ F + E; F, E in p/s², v_s in p/s
///
/// Source: R. Stribeck (1902); Armstrong-Hélouvry et al., Automatica 30 (1994), Eq. 3.
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
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "stribeck_friction",
                title: "Stribeck friction",
                variable: "velocity",
                confused_with: &["coulomb_friction", "bouc_wen_hysteresis"],
                parameters: &[
                    amount("force_per_inertia", "p/s²"),
                    amount("extra_static", "p/s²"),
                    shape("stribeck_velocity", "p/s"),
                    CREEP,
                ],
                creeps: true,
                kept: 3,
                experiment: SLOW_TRIANGLES,
                abrupt: true,
                ..Facts::USUAL
            }
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
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        // Beyond the speeds of the recording the fall of the friction is a viscous damping.
        parameters[0] >= 0.0 && parameters[1] > 0.0 && parameters[2] < 3.0 * scale.speed
    }
}
