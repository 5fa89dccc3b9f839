//! The formulas of the effects, each written once for plain numbers and for those with derivatives.

use std::f64::consts::TAU;

use physics::number::Number;

use super::Flow;
use crate::dynamic::structure::shape;
use crate::thresholds::dynamic::effects::bouc_wen_hysteresis::USUAL;
use crate::thresholds::dynamic::effects::friction::GAUSSIAN;

/// What an effect does with its parameters: the declarations give the formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the declarations say what the laws are
pub enum Law {
    /// Nothing of its own: the simulation does what its [`Part`](super::Part) says.
    None,
    Offset,
    Limit,
    Cubic,
    Square,
    Drag,
    Damping,
    Droop,
    Cogging,
    Coulomb,
    Stribeck,
    LocalFriction,
    Backlash,
    BoucWen,
    FlexibleMode,
    /// One shape of a family without a physical name (`structure`).
    Shape {
        family: usize,
        index: usize,
    },
}

impl Law {
    /// Adds to the acceleration and sets the rates of the effect's states ([`Part::Force`](super::Part::Force)).
    #[inline(always)]
    pub fn force<T: Number>(self, p: &[T], flow: &mut Flow<T>) {
        let (x, v) = (*flow.position, *flow.velocity);
        let force = match self {
            Law::None | Law::Offset | Law::Limit => return,
            Law::Cubic => p[0] * x * x * x,
            Law::Square => p[0] * x * x,
            Law::Drag => p[0] * v * v.abs(),
            Law::Damping => p[0] * x * x * v,
            Law::Droop => *flow.gain * *flow.drive * p[0] * x * x,
            Law::Cogging => {
                let (sin, cos) = (x * TAU / p[2]).sin_cos();
                *flow.acceleration = *flow.acceleration - p[0] * sin;
                p[1] * cos
            }
            Law::Coulomb => p[0] * flow.direction,
            Law::Stribeck => {
                let relative = v / p[2];
                let exponent = p[4].value();
                let power =
                    if exponent == GAUSSIAN { relative * relative } else { relative.abs().powf(exponent) };
                (p[0] + p[1] * (-power).exp()) * flow.direction
            }
            Law::LocalFriction => {
                let from = (x - p[1]) / p[2];
                p[0] * (-(from * from)).exp() * flow.direction
            }
            Law::Backlash => {
                // How far the play is from its middle, and whether the motion carries its end along.
                let off = flow.states[0].value();
                let carried = off * v.value() > 0.0 && off.abs() >= 0.5 * p[1].value();
                flow.rates[0] = if carried { T::from_f64(0.0) } else { v };
                p[0] * if carried { 0.0 } else { -flow.direction }
            }
            Law::BoucWen => {
                let z = flow.states[0];
                let [beta, exponent] = [p[2].value(), p[3].value()];
                flow.rates[0] = if [beta, exponent] == USUAL {
                    v - (v.abs() * z + v * z.abs()) * 0.5 / p[1]
                } else {
                    let sign = if z.value() < 0.0 { -1.0 } else { 1.0 };
                    let yielding = v.abs() * (beta * sign) + v * (1.0 - beta);
                    v - yielding * (z.abs() / p[1]).powf(exponent)
                };
                p[0] * z
            }
            Law::FlexibleMode => {
                let omega = p[0] * TAU;
                let h = omega * omega * (x - flow.states[0]) + omega * p[2] * (v - flow.states[1]) * 2.0;
                flow.rates[0] = flow.states[1];
                flow.rates[1] = h;
                p[1] * h
            }
            Law::Shape { family, index } => shape(family, index, p, flow),
        };
        *flow.acceleration = *flow.acceleration - force;
    }
}
