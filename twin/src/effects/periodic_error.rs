//! Periodic error, A sin(2πΘ/p + φ) of the true angle: the pads carry a grain of the period p, which adds
//! to the rotation that the probes see. Against the calculated angle it is implicit, since that carries the
//! error itself. Further harmonics fall off threefold each.

use std::f64::consts::TAU;

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::{arcsec_from_rad, rad_from_arcsec};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "periodic_error",
    title: "a periodic error of the true angle",
    scope: Scope::Device,
    depends_on: &["angle_deg"],
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
            name: "period_arcsec",
            unit: "arcsec",
            default: None,
            range: (1.0, 1e5),
            drawn: Drawn::PeriodFromSteps(2.6, 0.2),
        },
        Parameter {
            name: "phase_deg",
            unit: "deg",
            default: Some(0.0),
            range: (-360.0, 360.0),
            drawn: Drawn::Uniform(0.0, 360.0),
        },
        Parameter {
            name: "harmonics",
            unit: "1",
            default: Some(1.0),
            range: (1.0, 8.0),
            drawn: Drawn::Whole(1, 1),
        },
    ],
    build: |values, _| {
        let (amplitude, period) = (values["amplitude_arcsec"], values["period_arcsec"]);
        let harmonics = values["harmonics"];
        if harmonics.fract() != 0.0 {
            return Err(format!("`harmonics` is {harmonics}, expected a whole number"));
        }
        // Every harmonic's slope is at most 2πA/p, the falling amplitude making up for the frequency.
        if TAU * amplitude.abs() * harmonics / period > 0.5 {
            return Err(format!(
                "an amplitude of {amplitude} arcsec in a period of {period} arcsec could turn the reading back"
            ));
        }
        Ok(Box::new(Grain {
            amplitude_rad: rad_from_arcsec(amplitude),
            period_arcsec: period,
            phase: values["phase_deg"].to_radians(),
            harmonics: harmonics as u32,
        }))
    },
};

#[derive(Debug, Clone)]
struct Grain {
    amplitude_rad: f64,
    period_arcsec: f64,
    phase: f64,
    harmonics: u32,
}

impl Mechanism for Grain {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        let turn = TAU * arcsec_from_rad(pose.mirror_rad) / self.period_arcsec + self.phase;
        (1..=self.harmonics)
            .map(f64::from)
            // The phases of a ramp would make a saw-tooth; a radian apart they make no special shape.
            .map(|n| self.amplitude_rad / 3f64.powf(n - 1.0) * (n * turn + (n - 1.0)).sin())
            .sum()
    }
}
