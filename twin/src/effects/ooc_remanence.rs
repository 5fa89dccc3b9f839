//! Outside the table: remanence after the largest excursion. A pad that comes close to a probe keeps some
//! magnetisation, of the sign of the last excursion, which fades as the pad moves away:
//! A · sign · e^(−|φ − φ_end| / width).

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_remanence",
    title: "remanence of the pads after the largest excursion",
    scope: Scope::Device,
    depends_on: &["history", "direction", "angle_deg", "command_deg"],
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
            name: "width_deg",
            unit: "deg",
            default: Some(0.6),
            range: (0.05, 5.0),
            drawn: Drawn::Uniform(0.4, 1.0),
        },
        Parameter {
            name: "beyond_deg",
            unit: "deg",
            default: Some(1.2),
            range: (0.0, 1.8),
            drawn: Drawn::Uniform(1.1, 1.3),
        },
    ],
    build: |values, _| {
        Ok(Box::new(Pads {
            amplitude_rad: rad_from_arcsec(values["amplitude_arcsec"]),
            width_rad: values["width_deg"].to_radians(),
            beyond_rad: values["beyond_deg"].to_radians(),
            end_rad: 0.0,
        }))
    },
};

#[derive(Debug, Clone)]
struct Pads {
    amplitude_rad: f64,
    width_rad: f64,
    /// Excursions beyond this leave a trace.
    beyond_rad: f64,
    /// Where the last such excursion went; 0 before the first.
    end_rad: f64,
}

impl Mechanism for Pads {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        if self.end_rad == 0.0 {
            return 0.0;
        }
        let away = (pose.frame_rad - self.end_rad).abs() / self.width_rad;
        self.amplitude_rad * self.end_rad.signum() * (-away).exp()
    }

    fn settled(&mut self, pose: &Pose) {
        let here = pose.frame_rad;
        let further = here.abs() > self.end_rad.abs() || here * self.end_rad < 0.0;
        if here.abs() > self.beyond_rad && further {
            self.end_rad = here;
        }
    }
}
