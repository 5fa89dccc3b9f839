//! Coulomb friction: dry friction of constant magnitude against the motion; it holds the mechanism where the other forces are smaller.

use super::{COULOMB_FRICTION, CREEP, DynamicEffect, Facts, Flow, Physics, SLOW_TRIANGLES, Scale, amount};
use crate::numerics::Number;
use crate::thresholds::dynamic::effects::HARD;

/// x″ −= F sign v; stuck where |force| ≤ F; F in p/s²
///
/// Source: C. A. Coulomb (1785); Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998).
pub struct CoulombFriction;

impl<T: Number> Physics<T> for CoulombFriction {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        *flow.acceleration = *flow.acceleration - parameters[0] * flow.direction;
    }
}

impl DynamicEffect for CoulombFriction {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: COULOMB_FRICTION,
                title: "Coulomb friction",
                variable: "velocity",
                confused_with: &["stribeck_friction", "bouc_wen_hysteresis", "quadratic_damping"],
                parameters: &[amount("force_per_inertia", "p/s²"), CREEP],
                creeps: true,
                kept: 1,
                experiment: SLOW_TRIANGLES,
                abrupt: true,
                ..Facts::USUAL
            }
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        vec![vec![0.0, HARD * scale.speed]]
    }
    fn plausible(&self, parameters: &[f64], _: &Scale) -> bool {
        parameters[0] > 0.0
    }
}
