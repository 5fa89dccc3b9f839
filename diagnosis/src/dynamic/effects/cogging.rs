//! Cogging: a force that repeats with the position: the teeth of a motor, the balls of a bearing.

use std::f64::consts::TAU;

use super::{DynamicEffect, Facts, Flow, Physics, Reading, Scale, amount, shape};
use crate::numerics::Number;

/// x″ −= A sin(2πx/p + φ); A in p/s², p in p
///
/// Source: Hanselman, Brushless Permanent Magnet Motor Design (2003), chapter 6.
pub struct Cogging;

impl<T: Number> Physics<T> for Cogging {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let angle = *flow.position * TAU / parameters[2];
        let (sin, cos) = angle.sin_cos();
        *flow.acceleration = *flow.acceleration - parameters[0] * sin - parameters[1] * cos;
    }
}

impl DynamicEffect for Cogging {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "cogging",
                title: "Cogging",
                variable: "position",
                confused_with: &["cubic_stiffness", "quadratic_stiffness"],
                parameters: &[amount("sine", "p/s²"), amount("cosine", "p/s²"), shape("period", "p")],
                ..Facts::USUAL
            }
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        // Steps of half a turn over the whole stroke: between two of them a period is at most a quarter of a
        // turn out over the stroke, an eighth at either end, and still shows.
        let span = 2.0 * scale.stroke;
        (0..40).map(|k| vec![0.0, 0.0, span / (0.8 + 0.5 * k as f64)]).collect()
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        // Less than one and a half turns within the stroke are a polynomial of the position.
        parameters[2] < 2.0 * scale.stroke / 1.3
    }
    fn readings(&self, parameters: &[f64]) -> Vec<Reading> {
        let [a, b, period] = [parameters[0], parameters[1], parameters[2]];
        let amplitude = a.hypot(b).max(f64::MIN_POSITIVE);
        let square = amplitude * amplitude;
        let reading = |name, unit, value, gradient: [f64; 3]| Reading {
            name,
            unit,
            value,
            gradient: gradient.to_vec(),
        };
        vec![
            reading("amplitude_per_inertia", "p/s²", amplitude, [a / amplitude, b / amplitude, 0.0]),
            reading("period", "p", period, [0.0, 0.0, 1.0]),
            reading("phase_rad", "rad", b.atan2(a), [-b / square, a / square, 0.0]),
        ]
    }
    fn parameters_from(&self, value: &dyn Fn(&str) -> Option<f64>) -> Option<Vec<f64>> {
        let (amplitude, phase) = (value("amplitude_per_inertia")?, value("phase_rad").unwrap_or(0.0));
        Some(vec![amplitude * phase.cos(), amplitude * phase.sin(), value("period")?])
    }
}
