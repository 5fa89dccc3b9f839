//! Outside the table: the square of the temperature, κ (T − 27 °C)². Two metals of the bracket whose
//! expansions cancel in the first order only.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::environment::LABORATORY_C;
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_temperature_square",
    title: "the zero goes with the square of the temperature",
    scope: Scope::Device,
    depends_on: &["temperature_c"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_k2",
        unit: "arcsec/K²",
        default: None,
        range: (-100.0, 100.0),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Bimetal { arcsec_per_k2: values["coefficient_arcsec_per_k2"] })),
};

#[derive(Debug, Clone)]
struct Bimetal {
    arcsec_per_k2: f64,
}

impl Mechanism for Bimetal {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        rad_from_arcsec(self.arcsec_per_k2 * (pose.temperature_c - LABORATORY_C).powi(2))
    }
}
