//! Outside the table: the building sways, A sin(2πt/P + φ), and the table of the autocollimator with it.

use std::f64::consts::TAU;

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_sway",
    title: "the table sways with time",
    scope: Scope::Recording,
    depends_on: &["t_s", "history"],
    times: None,
    parameters: &[
        Parameter {
            name: "amplitude_arcsec",
            unit: "arcsec",
            default: None,
            range: (-1e3, 1e3),
            drawn: Drawn::PositiveStrength,
        },
        Parameter {
            name: "period_s",
            unit: "s",
            default: None,
            range: (1.0, 1e6),
            drawn: Drawn::OfDuration(0.1, 0.3),
        },
        Parameter {
            name: "phase_deg",
            unit: "deg",
            default: Some(0.0),
            range: (-360.0, 360.0),
            drawn: Drawn::Uniform(0.0, 360.0),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Building {
            amplitude_arcsec: values["amplitude_arcsec"],
            period_s: values["period_s"],
            phase: values["phase_deg"].to_radians(),
        }))
    },
};

#[derive(Debug, Clone)]
struct Building {
    amplitude_arcsec: f64,
    period_s: f64,
    phase: f64,
}

impl Mechanism for Building {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        -self.amplitude_arcsec * (TAU * pose.t_s / self.period_s + self.phase).sin()
    }
}
