//! Coil crosstalk, η · i: the field of the voice coils reaches the probes, one from each side, and adds to
//! their reports in proportion to the current. The sensitivity dΘ/ds varies by a few per cent over the
//! stroke; the pick-up is chosen for its mean.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "coil_crosstalk",
    title: "the coil current is picked up by the probes",
    scope: Scope::Device,
    depends_on: &["coil_a"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_a",
        unit: "arcsec/A",
        default: None,
        range: (-1e4, 1e4),
        drawn: Drawn::Strength,
    }],
    build: |values, device| {
        let mm_per_a = values["coefficient_arcsec_per_a"] / device.arcsec_per_mm();
        Ok(Box::new(PickUp { mm_per_a }))
    },
};

#[derive(Debug, Clone)]
struct PickUp {
    /// Millimetres of s per ampere.
    mm_per_a: f64,
}

impl Mechanism for PickUp {
    fn report(&self, pose: &Pose, reports_mm: &mut [f64; 2]) {
        let half = 0.5 * self.mm_per_a * pose.coil_a;
        reports_mm[0] -= half;
        reports_mm[1] += half;
    }
}
