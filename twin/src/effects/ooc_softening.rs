//! Outside the table: an adhesive that softens, A tanh((T − T_s)/w). The bracket lets go of its stress where
//! the temperature passes T_s.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_softening",
    title: "an adhesive softens at one temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
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
            name: "softening_c",
            unit: "°C",
            default: Some(27.0),
            range: (-40.0, 100.0),
            drawn: Drawn::Uniform(25.0, 30.0),
        },
        Parameter {
            name: "width_k",
            unit: "K",
            default: Some(0.5),
            range: (0.01, 50.0),
            drawn: Drawn::Uniform(0.3, 1.0),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Adhesive {
            amplitude_rad: rad_from_arcsec(values["amplitude_arcsec"]),
            softening_c: values["softening_c"],
            width_k: values["width_k"],
        }))
    },
};

#[derive(Debug, Clone)]
struct Adhesive {
    amplitude_rad: f64,
    softening_c: f64,
    width_k: f64,
}

impl Mechanism for Adhesive {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        self.amplitude_rad * ((pose.temperature_c - self.softening_c) / self.width_k).tanh()
    }
}
