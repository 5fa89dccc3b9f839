//! Outside the table: creep that heat hastens, κ (T − 27 °C) t. The mount of the autocollimator creeps at a
//! rate that goes with the temperature.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::environment::LABORATORY_C;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_aging",
    title: "creep hastened by heat",
    scope: Scope::Recording,
    depends_on: &["temperature_c", "t_s", "history"],
    times: Some("t_s"),
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_k_h",
        unit: "arcsec/(K h)",
        default: None,
        range: (-1e4, 1e4),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Mount { arcsec_per_k_h: values["coefficient_arcsec_per_k_h"] })),
};

#[derive(Debug, Clone)]
struct Mount {
    arcsec_per_k_h: f64,
}

impl Mechanism for Mount {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        -self.arcsec_per_k_h * (pose.temperature_c - LABORATORY_C) * pose.t_s / 3600.0
    }
}
