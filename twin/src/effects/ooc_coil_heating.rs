//! Outside the table: the coils heat up with the square of their current and bend the frame,
//! A · H with τ dH/dt = (i / 0.1 A)² − H. Cold at the start.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::rad_from_arcsec;

/// The current to which the heating refers, about that at the end of the stroke.
const CURRENT_A: f64 = 0.1;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_coil_heating",
    title: "the coils heat up with the square of their current",
    scope: Scope::Device,
    depends_on: &["history", "coil_a", "t_s", "pass", "angle_deg", "direction"],
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
            drawn: Drawn::OfDuration(0.03, 0.15),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Coils {
            amplitude_rad: rad_from_arcsec(values["amplitude_arcsec"]),
            time_constant_s: values["time_constant_s"],
            heat: 0.0,
            t_s: 0.0,
        }))
    },
};

#[derive(Debug, Clone)]
struct Coils {
    amplitude_rad: f64,
    time_constant_s: f64,
    heat: f64,
    t_s: f64,
}

impl Mechanism for Coils {
    fn advance(&mut self, pose: &Pose) {
        // The pose still holds the current of the position that the mirror was held in.
        let kept = (-(pose.t_s - self.t_s) / self.time_constant_s).exp();
        self.heat = kept * self.heat + (1.0 - kept) * (pose.coil_a / CURRENT_A).powi(2);
        self.t_s = pose.t_s;
    }

    fn seen_rotation_rad(&self, _pose: &Pose) -> f64 {
        self.amplitude_rad * self.heat
    }
}
