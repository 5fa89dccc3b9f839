//! Dry friction: against the motion whatever its speed; it holds the mechanism where the other forces are smaller.

use super::{COULOMB_FRICTION, CREEP, DynamicEffect, Law, SLOW_TRIANGLES, amount, shape};
use crate::thresholds::dynamic::effects::HARD;

/// Coulomb friction: of constant magnitude.
///
/// Source: C. A. Coulomb (1785); Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998).
pub static COULOMB: DynamicEffect = DynamicEffect {
    id: COULOMB_FRICTION,
    title: "Coulomb friction",
    formula: "x″ −= F sign v; stuck where |force| ≤ F",
    confused_with: &["stribeck_friction", "bouc_wen_hysteresis", "quadratic_damping"],
    law: Law::Coulomb,
    parameters: &[amount("force_per_inertia", "p/s²"), CREEP],
    kept: 1,
    starts: |scale| vec![vec![0.0, HARD * scale.speed]],
    plausible: |parameters, _| parameters[0] > 0.0,
    ..DRY
};

/// Stribeck friction: larger at rest, and falls with speed.
///
/// Source: R. Stribeck (1902); Armstrong-Hélouvry et al., Automatica 30 (1994), Eq. 3.
pub static STRIBECK: DynamicEffect = DynamicEffect {
    id: "stribeck_friction",
    title: "Stribeck friction",
    formula: "x″ −= (F + E exp(−(v/v_s)²)) sign v; stuck where |force| ≤ F + E",
    confused_with: &[COULOMB_FRICTION, "bouc_wen_hysteresis"],
    law: Law::Stribeck,
    parameters: &[
        amount("force_per_inertia", "p/s²"),
        amount("extra_static", "p/s²"),
        shape("stribeck_velocity", "p/s"),
        CREEP,
    ],
    kept: 3,
    starts: |scale| {
        let start = |part: &f64| vec![0.0, 0.0, part * scale.speed, HARD * scale.speed];
        [0.03, 0.1, 0.3, 1.0].iter().map(start).collect()
    },
    starts_from: |simpler, parameters, scale| match (simpler, parameters) {
        (COULOMB_FRICTION, [force, creep]) => {
            let start = |part: &f64| vec![0.9 * force, 0.3 * force, part * scale.speed, *creep];
            [0.1, 0.3, 1.0].iter().map(start).collect()
        }
        _ => Vec::new(),
    },
    special_case: Some(&COULOMB),
    // Beyond the speeds of the recording the fall of the friction is a viscous damping.
    plausible: |parameters, scale| {
        parameters[0] >= 0.0 && parameters[1] > 0.0 && parameters[2] < 3.0 * scale.speed
    },
    ..DRY
};

const DRY: DynamicEffect = DynamicEffect {
    variable: "velocity",
    creeps: true,
    experiment: SLOW_TRIANGLES,
    abrupt: true,
    ..DynamicEffect::USUAL
};
