//! Bouc–Wen hysteresis: a spring that yields: a restoring force with a memory of the motion, which dissipates at any speed.

use super::{COULOMB_FRICTION, DynamicEffect, Law, SLOW_TRIANGLES, amount, plain_readings, shape};
use crate::thresholds::dynamic::effects::bouc_wen_hysteresis::USUAL;

/// Source: R. Bouc (1967); Y. K. Wen, J. Eng. Mech. Div. 102 (1976); Ismail, Ikhouane & Rodellar (2009).
pub static BOUC_WEN_HYSTERESIS: DynamicEffect = DynamicEffect {
    id: "bouc_wen_hysteresis",
    title: "Bouc–Wen hysteresis",
    formula: "x″ −= k z, z′ = v − ½(|v| z + v |z|)/Y",
    variable: "history",
    confused_with: &[COULOMB_FRICTION, "stribeck_friction"],
    law: Law::BoucWen,
    parameters: &[
        amount("stiffness", "1/s²"),
        shape("yield", "p"),
        shape("beta", "1").usually(USUAL[0]),
        shape("exponent", "1").usually(USUAL[1]),
    ],
    states: 1,
    kept: 2,
    experiment: SLOW_TRIANGLES,
    abrupt: true,
    starts: |scale| {
        [0.02, 0.06, 0.2, 0.6].iter().map(|part| vec![0.0, part * scale.stroke, USUAL[0], USUAL[1]]).collect()
    },
    // A spring that never yields is a spring, one that yields at once is dry friction.
    plausible: |parameters, scale| {
        parameters[0] > 0.0 && parameters[1] < 3.0 * scale.stroke && parameters[1] > 1e-3 * scale.stroke
    },
    readings: |effect, parameters| {
        let count = if parameters[2..] == USUAL { 2 } else { 4 };
        plain_readings(effect.parameters, parameters, count)
    },
    ..DynamicEffect::USUAL
};
