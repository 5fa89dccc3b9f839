//! Dry friction (Coulomb): F against the motion whatever its speed; at rest it holds against any force up to
//! F.

use super::specification::NOT_NEGATIVE;
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "coulomb_friction",
    title: "dry friction",
    depends_on: &["velocity", "position", "history", "amplitude"],
    parameters: &[Parameter {
        name: "force_per_inertia",
        unit: "position unit/s²",
        default: None,
        range: NOT_NEGATIVE,
    }],
    build: |values, _| Ok(Action::Force(Box::new(Dry { level: values["force_per_inertia"] }))),
    draw: |strength, typical, _| vec![("force_per_inertia", strength * typical.acceleration())],
};

#[derive(Debug)]
struct Dry {
    level: f64,
}

impl Force for Dry {
    fn is_dry(&self) -> bool {
        true
    }

    fn friction(&self, _: &Motion, _: f64) -> f64 {
        self.level
    }
}
