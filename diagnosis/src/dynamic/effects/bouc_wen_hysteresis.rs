//! Bouc–Wen hysteresis: a spring that yields: a restoring force with a memory of the motion, which dissipates at any speed.

use super::{
    DynamicEffect, Facts, Flow, Physics, Reading, SLOW_TRIANGLES, Scale, amount, plain_readings, shape,
};
use crate::numerics::Number;
use crate::thresholds::dynamic::effects::bouc_wen_hysteresis::USUAL;

/// x″ −= k z, z′ = v − ½(|v| z + v |z|)/Y; k in 1/s², Y in p
///
/// Source: R. Bouc (1967); Y. K. Wen, J. Eng. Mech. Div. 102 (1976); Ismail, Ikhouane & Rodellar (2009).
pub struct BoucWenHysteresis;

impl<T: Number> Physics<T> for BoucWenHysteresis {
    #[inline(always)]
    fn force(&self, parameters: &[T], flow: &mut Flow<T>) {
        let (v, z) = (*flow.velocity, flow.states[0]);
        let [beta, exponent] = [parameters[2].value(), parameters[3].value()];
        *flow.acceleration = *flow.acceleration - parameters[0] * z;
        flow.rates[0] = if [beta, exponent] == USUAL {
            v - (v.abs() * z + v * z.abs()) * 0.5 / parameters[1]
        } else {
            let sign = if z.value() < 0.0 { -1.0 } else { 1.0 };
            let yielding = v.abs() * (beta * sign) + v * (1.0 - beta);
            v - yielding * (z.abs() / parameters[1]).powf(exponent)
        };
    }
}

impl DynamicEffect for BoucWenHysteresis {
    fn facts(&self) -> &Facts {
        const {
            &Facts {
                id: "bouc_wen_hysteresis",
                title: "Bouc–Wen hysteresis",
                variable: "history",
                confused_with: &["coulomb_friction", "stribeck_friction"],
                parameters: &[
                    amount("stiffness", "1/s²"),
                    shape("yield", "p"),
                    shape("beta", "1"),
                    shape("exponent", "1"),
                ],
                states: 1,
                kept: 2,
                experiment: SLOW_TRIANGLES,
                abrupt: true,
                ..Facts::USUAL
            }
        }
    }
    fn starts(&self, scale: &Scale) -> Vec<Vec<f64>> {
        [0.02, 0.06, 0.2, 0.6].iter().map(|part| vec![0.0, part * scale.stroke, USUAL[0], USUAL[1]]).collect()
    }
    fn readings(&self, parameters: &[f64]) -> Vec<Reading> {
        let count = if parameters[2..] == USUAL { 2 } else { 4 };
        plain_readings(self.facts().parameters, parameters, count)
    }
    fn names(&self) -> Vec<&'static str> {
        self.facts().parameters.iter().map(|p| p.name).collect()
    }
    fn parameters_from(&self, value: &dyn Fn(&str) -> Option<f64>) -> Option<Vec<f64>> {
        let usual = |name, usual: f64| Some(value(name).unwrap_or(usual));
        let all = [value("stiffness"), value("yield"), usual("beta", USUAL[0]), usual("exponent", USUAL[1])];
        all.into_iter().collect()
    }
    fn plausible(&self, parameters: &[f64], scale: &Scale) -> bool {
        // A spring that never yields is a spring, one that yields at once is dry friction.
        parameters[0] > 0.0 && parameters[1] < 3.0 * scale.stroke && parameters[1] > 1e-3 * scale.stroke
    }
}
