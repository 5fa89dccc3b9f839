//! Read lag, τ dθ/dt: the autocollimator's camera integrates, so that what it reads is the angle of a
//! moment before the probes were sampled. It shows only where the mirror moves while it is read.
//!
//! In true angle this adds τ dΘ/dt; the table's θ is the calculated angle, a nearly constant factor larger.
//! The delay of the camera is chosen so that the two agree over the stroke.

use super::{Drawn, Mechanism, Parameter, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "read_lag",
    title: "the reference is read later than the probes",
    scope: Scope::Device,
    depends_on: &["velocity", "direction"],
    times: None,
    parameters: &[Parameter {
        name: "delay_s",
        unit: "s",
        default: None,
        range: (-10.0, 10.0),
        drawn: Drawn::Strength,
    }],
    build: |values, device| {
        Ok(Box::new(Camera { delay_s: values["delay_s"] / device.true_per_calculated() }))
    },
};

#[derive(Debug, Clone)]
struct Camera {
    delay_s: f64,
}

impl Mechanism for Camera {
    fn reference_delay_s(&self) -> f64 {
        self.delay_s
    }
}
