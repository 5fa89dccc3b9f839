//! Outside the table: the square of the second axis, κ · cross². A beam that leaves the plane of measurement
//! meets the scale of the autocollimator at a slant.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_cross_square",
    title: "the square of the second axis",
    scope: Scope::Device,
    depends_on: &["cross_arcsec"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_per_arcsec",
        unit: "1/arcsec",
        default: None,
        range: (-20.0, 20.0),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Slant { per_arcsec: values["coefficient_per_arcsec"] })),
};

#[derive(Debug, Clone)]
struct Slant {
    per_arcsec: f64,
}

impl Mechanism for Slant {
    fn reference_arcsec(&self, pose: &Pose) -> f64 {
        -self.per_arcsec * pose.cross_arcsec * pose.cross_arcsec
    }
}
