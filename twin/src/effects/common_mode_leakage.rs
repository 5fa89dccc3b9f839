//! Common-mode leakage, λ (x₁+x₂)/2: the plate really moves along X, and the amplifiers of the two probes
//! have unequal gains, so that the movement does not cancel in s = x₂ − x₁.
//!
//! Gains 1 ± g turn s into s + g (x₁+x₂), which adds g (x₁+x₂)·dΘ/ds. dΘ/ds varies by a few per cent over
//! the stroke; g is chosen for its mean. They also put g s/2 into the measured (x₁+x₂)/2: beside a polynomial of s the
//! angle then goes with it by 1/(1 − g²) more, and λ is what is measured.

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
        // g/(1 − g²) = λ / (2 dΘ/ds), solved for the g that vanishes with λ.
        let ratio = arcsec_per_mm / device.arcsec_per_mm();
        Ok(Box::new(Amplifiers { mismatch: ratio / (1.0 + (1.0 + ratio * ratio).sqrt()) }))
    },
};

#[derive(Debug, Clone)]
struct Amplifiers {
    /// g: gains are 1 − g and 1 + g.
    mismatch: f64,
}

impl Mechanism for Amplifiers {
    fn report(&self, _pose: &Pose, reports_mm: &mut [f64; 2]) {
        reports_mm[0] *= 1.0 - self.mismatch;
        reports_mm[1] *= 1.0 + self.mismatch;
    }
}
