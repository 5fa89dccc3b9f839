//! A local defect, a Gaussian bump in θ: a flaw in the pad of probe 2, which comes under the probe at one
//! deflection. Place, width and height at the probe follow from the geometry there.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::arcsec_from_rad;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "local_defect",
    title: "a flaw of a pad at one angle",
    scope: Scope::Device,
    depends_on: &["angle_deg"],
    times: None,
    parameters: &[
        Parameter {
            name: "height_arcsec",
            unit: "arcsec",
            default: None,
            range: (-1e3, 1e3),
            drawn: Drawn::Strength,
        },
        Parameter {
            name: "centre_deg",
            unit: "deg",
            default: None,
            range: (-1.75, 1.75),
            drawn: Drawn::EitherSide(0.0, 0.75),
        },
        Parameter {
            name: "width_deg",
            unit: "deg",
            default: None,
            range: (0.005, 1.0),
            drawn: Drawn::FromSteps(0.8, 0.05),
        },
    ],
    build: |values, device| {
        let centre_rad = values["centre_deg"].to_radians();
        let d = device.geometry.probe_distance_mm;
        let s_mm = d * centre_rad.tan();
        let (reports_mm, shares) = device.reports_at(s_mm);
        let arcsec_per_mm = arcsec_from_rad(device.probes.error.slope_rad_per_mm(s_mm));
        let s_per_rad = d / centre_rad.cos().powi(2);
        Ok(Box::new(Flaw {
            height_mm: values["height_arcsec"] / arcsec_per_mm,
            centre_mm: reports_mm[1],
            width_mm: shares[1] * s_per_rad * values["width_deg"].to_radians(),
        }))
    },
};

#[derive(Debug, Clone)]
struct Flaw {
    height_mm: f64,
    centre_mm: f64,
    width_mm: f64,
}

impl Mechanism for Flaw {
    fn report(&self, _pose: &Pose, reports_mm: &mut [f64; 2]) {
        let z = (reports_mm[1] - self.centre_mm) / self.width_mm;
        reports_mm[1] += self.height_mm * (-0.5 * z * z).exp();
    }
}
