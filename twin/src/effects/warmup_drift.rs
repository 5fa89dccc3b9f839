//! Drift after switch-on, A (1 − e^(−t/τ)): the electronics of the autocollimator warm up at t = 0 and
//! turn its optics in proportion to their own rise in temperature.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "warmup_drift",
    title: "the zero drifts after switch-on and comes to rest",
    scope: Scope::Recording,
    depends_on: &["t_s"],
    times: None,
    parameters: &[
        Parameter {
            name: "amplitude_arcsec",
            unit: "arcsec",
            default: None,
            range: (-1e3, 1e3),
            drawn: Drawn::Strength,
        },
        Parameter {
            name: "time_constant_s",
            unit: "s",
            default: None,
            range: (1.0, 1e5),
            drawn: Drawn::OfDuration(0.08, 0.3),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Electronics {
            amplitude_arcsec: values["amplitude_arcsec"],
            time_constant_s: values["time_constant_s"],
        }))
    },
};

#[derive(Debug, Clone)]
struct Electronics {
    amplitude_arcsec: f64,
    time_constant_s: f64,
}

impl Mechanism for Electronics {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        // exp_m1 is e^x − 1 without cancellation.
        self.amplitude_arcsec * (-pose.t_s / self.time_constant_s).exp_m1()
    }
}
