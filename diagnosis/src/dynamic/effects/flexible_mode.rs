//! Flexible mode: a second inertia on a spring that moves with the mechanism and resonates by itself.

use std::f64::consts::TAU;

use super::{DynamicEffect, FASTER, Facts, Flow, Physics, Scale, amount, shape};
use crate::numerics::Number;

/// x″ −= μ h, q″ = h, h = Ω²(x − q) + 2ζΩ(v − q′), Ω = 2πf; f in Hz, μ and ζ without unit
///
/// Source: Den Hartog, Mechanical Vibrations (1956), section 3.2.
pub struct FlexibleMode;

impl<T: Number> Physics<T> for FlexibleMode {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let omega = parameters[0] * TAU;
        let h = omega * omega * (*flow.position - flow.states[0])
            + omega * parameters[2] * (*flow.velocity - flow.states[1]) * 2.0;
        *flow.acceleration = *flow.acceleration - parameters[1] * h;
        flow.rates[0] = flow.states[1];
        flow.rates[1] = h;
    }
}

impl DynamicEffect for FlexibleMode {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "flexible_mode",
                title: "Flexible mode",
                variable: "frequency_hz",
                confused_with: &["drive_lag", "sensor_lag"],
                parameters: &[
                    shape("frequency_hz", "Hz"),
                    amount("mass_ratio", "1"),
                    shape("damping_ratio", "1"),
                ],
                states: 2,
                experiment: FASTER,
                ..Facts::USUAL
            }
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        {
            // From half the mechanism's own rate to where the recording can still show it.
            let (low, high) = (0.5 * scale.rate / TAU, 0.4 / scale.step_s);
            let ratio = (high / low).max(1.0);
            let count = (6.0 * ratio.ln()).ceil().max(1.0) as usize;
            (0..=count).map(|k| vec![low * ratio.powf(k as f64 / count as f64), 0.0, 0.02]).collect()
        }
    }
    fn rest(&self, position: f64) -> [f64; 2] {
        [position, 0.0]
    }
    fn fastest(&self, parameters: &[f64]) -> f64 {
        parameters[0] * TAU * (1.0 + parameters[1].max(0.0)).sqrt()
    }
    fn memory_s(&self, parameters: &[f64]) -> f64 {
        // To 3·10⁻⁴ of its swing.
        8.0 / (parameters[0] * TAU * parameters[2])
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        parameters[1] > 0.0 && parameters[2] < 0.5 && parameters[0] < 0.5 / scale.step_s
    }
    fn parameters_from(&self, value: &dyn Fn(&str) -> Option<f64>) -> Option<Vec<f64>> {
        Some(vec![value("frequency_hz")?, value("mass_ratio")?, value("damping_ratio").unwrap_or(0.01)])
    }
}
