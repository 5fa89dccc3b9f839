//! Flexible mode: a second inertia on a spring that moves with the mechanism and resonates by itself.

use std::f64::consts::TAU;

use super::{DynamicEffect, FASTER, Law, amount, shape};
use crate::thresholds::dynamic::effects::flexible_mode::STARTS_PER_E_FOLD;

/// Source: Den Hartog, Mechanical Vibrations (1956), section 3.2.
pub static FLEXIBLE_MODE: DynamicEffect = DynamicEffect {
    id: "flexible_mode",
    title: "Flexible mode",
    formula: "x″ −= μ h, q″ = h, h = Ω²(x − q) + 2ζΩ(v − q′), Ω = 2πf",
    variable: "frequency_hz",
    confused_with: &["drive_lag", "sensor_lag"],
    law: Law::FlexibleMode,
    parameters: &[
        shape("frequency_hz", "Hz"),
        amount("mass_ratio", "1"),
        shape("damping_ratio", "1").usually(0.01),
    ],
    states: 2,
    experiment: FASTER,
    starts: |scale| {
        // A mechanism may be driven far below or above its own resonance.
        let (low, high) = (scale.slowest_hz, 0.4 / scale.step_s);
        let ratio = (high / low).max(1.0);
        let count = (STARTS_PER_E_FOLD * ratio.ln()).ceil().max(1.0) as usize;
        (0..=count).map(|k| vec![low * ratio.powf(k as f64 / count as f64), 0.0, 0.02]).collect()
    },
    rest: |position| [position, 0.0],
    fastest: |parameters| parameters[0] * TAU * (1.0 + parameters[1].max(0.0)).sqrt(),
    // To 3·10⁻⁴ of its swing.
    memory_s: |parameters| 8.0 / (parameters[0] * TAU * parameters[2]),
    plausible: |parameters, scale| {
        parameters[1] > 0.0 && parameters[2] < 0.5 && parameters[0] < 0.5 / scale.step_s
    },
    ..DynamicEffect::USUAL
};
