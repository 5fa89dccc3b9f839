//! Outside the table: a seal that is folded over drags in one direction only, and the more the further it is
//! stretched: F·(1 + x/x₀), not below 0, against forward motion.

use super::specification::{NOT_NEGATIVE, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "ooc_asymmetric_friction",
    title: "dry friction of one direction that grows along the stroke",
    depends_on: &["velocity", "position"],
    parameters: &[
        Parameter {
            name: "force_per_inertia", unit: "position unit/s²", default: None, range: NOT_NEGATIVE
        },
        Parameter {
            name: "position_scale",
            unit: "position unit",
            default: None,
            range: (f64::MIN_POSITIVE, f64::INFINITY),
        },
    ],
    build: |values, _| {
        Ok(Action::Force(Box::new(Seal {
            level: values["force_per_inertia"],
            scale: values["position_scale"],
        })))
    },
    draw: |strength, typical, generator| {
        vec![
            ("force_per_inertia", 2.0 * strength * typical.acceleration()),
            ("position_scale", typical.position * uniform(generator, 0.6, 1.2)),
        ]
    },
};

#[derive(Debug)]
struct Seal {
    level: f64,
    scale: f64,
}

impl Force for Seal {
    fn is_dry(&self) -> bool {
        true
    }

    fn friction(&self, at: &Motion, direction: f64) -> f64 {
        if direction > 0.0 { (self.level * (1.0 + at.x / self.scale)).max(0.0) } else { 0.0 }
    }
}
