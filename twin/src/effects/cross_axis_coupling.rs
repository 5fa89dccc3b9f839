//! Cross-axis coupling, χ · cross: the probes do not sit at the same height, so that a rotation about the
//! second axis moves the two pads differently along X. χ is the difference in height relative to d.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};
use crate::units::rad_from_arcsec;

pub(super) const SPECIFICATION: Specification = Specification {
    id: "cross_axis_coupling",
    title: "the second axis couples into the angle",
    scope: Scope::Device,
    depends_on: &["cross_arcsec"],
    times: None,
    parameters: &[Parameter {
        name: "coefficient_arcsec_per_arcsec",
        unit: "1",
        default: None,
        range: (-20.0, 20.0),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Heights { relative: values["coefficient_arcsec_per_arcsec"] })),
};

#[derive(Debug, Clone)]
struct Heights {
    relative: f64,
}

impl Mechanism for Heights {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        self.relative * rad_from_arcsec(pose.cross_arcsec)
    }
}
