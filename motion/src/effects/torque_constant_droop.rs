//! The coil leaves the field of its magnet: the gain is that at rest times 1 − δ·x².

use super::specification::ANY;
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "torque_constant_droop",
    title: "a torque constant that droops towards the ends of the stroke",
    depends_on: &["position", "drive", "amplitude"],
    parameters: &[Parameter { name: "droop", unit: "1/position unit²", default: None, range: ANY }],
    build: |values, _| Ok(Action::Force(Box::new(Coil { droop: values["droop"] }))),
    draw: |strength, typical, _| {
        let limit = 0.8 / typical.largest_position.powi(2);
        vec![("droop", (strength / typical.position.powi(2)).min(limit))]
    },
};

#[derive(Debug)]
struct Coil {
    droop: f64,
}

impl Force for Coil {
    fn drive_factor(&self, at: &Motion) -> f64 {
        1.0 - self.droop * at.x * at.x
    }
}
