//! Outside the table: a gain that depends on the direction of travel, γ·10⁻⁶ Θ·direction. Friction in the
//! bearing twists the frame in proportion to the load of the flexure.

use super::{Drawn, Mechanism, Parameter, Pose, Scope, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_direction_gain",
    title: "a gain that depends on the direction of travel",
    scope: Scope::Device,
    depends_on: &["direction", "angle_deg", "history"],
    times: Some("angle_deg"),
    parameters: &[Parameter {
        name: "coefficient_ppm",
        unit: "ppm",
        default: None,
        range: (-1e5, 1e5),
        drawn: Drawn::Strength,
    }],
    build: |values, _| Ok(Box::new(Bearing { part: 1e-6 * values["coefficient_ppm"] })),
};

#[derive(Debug, Clone)]
struct Bearing {
    part: f64,
}

impl Mechanism for Bearing {
    fn seen_rotation_rad(&self, pose: &Pose) -> f64 {
        self.part * pose.direction * pose.mirror_rad
    }
}
