//! Outside the table: the square of the common motion. A plate pushed either way along X strains its
//! suspension, and the strain turns the pads against the frame.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_common_mode_square",
    title: "the square of the common motion of the plate",
    scope: Scope::Device,
    depends_on: &["common_mode_um"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_um2",
        unit: "arcsec/µm²",
        default: None,
        range: (-200.0, 200.0),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Suspension { arcsec_per_um2: values["coefficient_arcsec_per_um2"] })),
};

#[derive(Debug, Clone)]
struct Suspension {
    arcsec_per_um2: f64,
}

impl Mechanism for Suspension {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        rad_from_arcsec(self.arcsec_per_um2 * (1e3 * pose.translation_mm).powi(2))
    }
}
