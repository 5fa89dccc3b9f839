//! Cogging of the magnets, or a thread: x″ −= A·sin(2πx/p + φ).

use super::specification::{ANY, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "cogging",
    title: "a force that repeats along the stroke",
    depends_on: &["position"],
    parameters: &[
        Parameter { name: "amplitude_per_inertia", unit: "position unit/s²", default: None, range: ANY },
        Parameter {
            name: "period",
            unit: "position unit",
            default: None,
            range: (f64::MIN_POSITIVE, f64::INFINITY),
        },
        Parameter { name: "phase_rad", unit: "rad", default: Some(0.0), range: ANY },
    ],
    build: |values, _| {
        Ok(Action::Force(Box::new(Teeth {
            amplitude: values["amplitude_per_inertia"],
            per_position: std::f64::consts::TAU / values["period"],
            phase_rad: values["phase_rad"],
        })))
    },
    draw: |strength, typical, generator| {
        let period = typical.position * uniform(generator, 0.7, 2.0);
        vec![
            ("amplitude_per_inertia", strength * typical.acceleration()),
            ("period", period),
            // Where the teeth stand is nobody's choice.
            ("phase_rad", uniform(generator, 0.0, std::f64::consts::TAU)),
        ]
    },
};

#[derive(Debug)]
struct Teeth {
    amplitude: f64,
    /// 2π/p.
    per_position: f64,
    phase_rad: f64,
}

impl Force for Teeth {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        -self.amplitude * (self.per_position * at.x + self.phase_rad).sin()
    }
}
