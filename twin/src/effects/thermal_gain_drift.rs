//! Thermal gain drift, γ·10⁻⁶ θ (T − T̄): the base expands and carries the probes apart, so that the same
//! rotation moves the pads at the probes further.
//!
//! What that adds is proportional to the true angle; the table's θ is the calculated one, a nearly constant
//! factor larger. The expansion is chosen so that the two agree over the stroke.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::environment::LABORATORY_C;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "thermal_gain_drift",
    title: "the gain drifts with the temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    times: Some("angle_deg"),
    parameters: &[Parameter {
        name: "coefficient_ppm_per_k",
        unit: "ppm/K",
        default: None,
        range: (-2000.0, 2000.0),
        drawn: Drawn::Strength,
    }],
    build: |values, device| {
        let per_k = 1e-6 * values["coefficient_ppm_per_k"] / device.true_per_calculated();
        Ok(Box::new(Base { per_k }))
    },
};

#[derive(Debug, Clone)]
struct Base {
    per_k: f64,
}

impl Mechanism for Base {
    fn probe_distance(&self, pose: &Pose) -> f64 {
        1.0 + self.per_k * (pose.temperature_c - LABORATORY_C)
    }
}
