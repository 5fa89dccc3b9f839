//! Bouc–Wen hysteresis: a spring that yields: a restoring force with a memory of the motion, which dissipates at any speed.

use super::{DynamicEffect, Flow, Parameter, Part, Physics, Scale, amount, shape};
use crate::dynamic::number::Number;

/// x″ −= k z, z′ = v − ½(|v| z + v |z|)/Y; k in 1/s², Y in p
pub struct BoucWenHysteresis;

impl<T: Number> Physics<T> for BoucWenHysteresis {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let (v, z) = (*flow.velocity, flow.states[0]);
        let yielding = (v.abs() * z + v * z.abs()) * 0.5;
        *flow.acceleration = *flow.acceleration - parameters[0] * z;
        flow.rates[0] = v - yielding / parameters[1];
    }
}

impl DynamicEffect for BoucWenHysteresis {
    fn id(&self) -> &'static str {
        "bouc_wen_hysteresis"
    }
    fn title(&self) -> &'static str {
        "Bouc–Wen hysteresis"
    }
    fn formula(&self) -> &'static str {
        "x″ −= k z, z′ = v − ½(|v| z + v |z|)/Y; k in 1/s², Y in p"
    }
    fn source(&self) -> &'static str {
        "R. Bouc (1967); Y. K. Wen, J. Eng. Mech. Div. 102 (1976); Ismail, Ikhouane & Rodellar (2009)"
    }
    fn confused_with(&self) -> &'static [&'static str] {
        &["coulomb_friction", "stribeck_friction"]
    }
    fn variable(&self) -> &'static str {
        "history"
    }
    fn part(&self) -> Part {
        Part::Force
    }
    fn parameters(&self) -> &'static [Parameter] {
        const { &[amount("stiffness", "1/s²"), shape("yield", "p")] }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.02, 0.06, 0.2, 0.6].iter().map(|part| vec![0.0, part * scale.stroke]).collect()
    }
    fn states(&self) -> usize {
        1
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        // A spring that never yields is a spring, one that yields at once is dry friction.
        parameters[0] > 0.0 && parameters[1] < 3.0 * scale.stroke && parameters[1] > 1e-3 * scale.stroke
    }
}
