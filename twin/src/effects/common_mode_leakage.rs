//! Common-mode leakage, λ (x₁+x₂)/2: the plate really moves along X, and the electronics that compare the two probes
//! let a part of what they have in common through, so that the movement does not cancel in s = x₂ − x₁.
//!
//! A part g of (x₁+x₂)/2 is taken from one reading and added to the other: s becomes s + g (x₁+x₂), which adds
//! g (x₁+x₂)·dΘ/ds, and (x₁+x₂)/2 stays. dΘ/ds varies by a few per cent over the stroke; g is chosen for its mean.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "common_mode_leakage",
    title: "common motion of the plate leaks into the angle",
    scope: Scope::Device,
    depends_on: &["common_mode_um"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_um",
        unit: "arcsec/µm",
        default: None,
        range: (-20.0, 20.0),
        drawn: Drawn::Strength,
    }],
    build: |values, device| {
        let arcsec_per_mm = 1e3 * values["coefficient_arcsec_per_um"];
        Ok(Box::new(Leak { part: 0.5 * arcsec_per_mm / device.arcsec_per_mm() }))
    },
};

#[derive(Debug, Clone)]
struct Leak {
    /// g.
    part: f64,
}

impl Mechanism for Leak {
    fn report(&self, _pose: &Pose, reports_mm: &mut [f64; 2]) {
        let leaked = self.part * 0.5 * (reports_mm[0] + reports_mm[1]);
        reports_mm[0] -= leaked;
        reports_mm[1] += leaked;
    }
}
