//! A step of the mount, h for t ≥ t₀: the autocollimator slips in its mount.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "mount_step",
    title: "the mount slips once",
    scope: Scope::Recording,
    depends_on: &["t_s"],
    times: None,
    parameters: &[
        Parameter {
            name: "step_arcsec",
            unit: "arcsec",
            default: None,
            range: (-1e3, 1e3),
            drawn: Drawn::Strength,
        },
        Parameter {
            name: "time_s",
            unit: "s",
            default: None,
            range: (0.0, 1e7),
            drawn: Drawn::OfDuration(0.15, 0.85),
        },
    ],
    build: |values, _| Ok(Box::new(Slip { step_arcsec: values["step_arcsec"], time_s: values["time_s"] })),
};

#[derive(Debug, Clone)]
struct Slip {
    step_arcsec: f64,
    time_s: f64,
}

impl Mechanism for Slip {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        if pose.t_s >= self.time_s { -self.step_arcsec } else { 0.0 }
    }
}
