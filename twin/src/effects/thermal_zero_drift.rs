//! Thermal zero drift, k (T − T̄): the bracket that carries both probes turns with its temperature against
//! the mount, so that the probes see a rotation that the mirror did not make.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::environment::LABORATORY_C;
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "thermal_zero_drift",
    title: "the zero drifts with the temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_k",
        unit: "arcsec/K",
        default: None,
        range: (-100.0, 100.0),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Bracket { arcsec_per_k: values["coefficient_arcsec_per_k"] })),
};

#[derive(Debug, Clone)]
struct Bracket {
    arcsec_per_k: f64,
}

impl Mechanism for Bracket {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        rad_from_arcsec(self.arcsec_per_k * (pose.temperature_c - LABORATORY_C))
    }
}
