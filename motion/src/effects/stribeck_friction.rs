//! Dry friction that falls as a film of oil builds up (Stribeck): F + E·exp(−(v/v_s)²) against the motion; at
//! rest it holds up to F + E. Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), 1083–1138.

use super::specification::{NOT_NEGATIVE, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub(super) const SPECIFICATION: Specification = Specification {
    id: "stribeck_friction",
    title: "dry friction that is larger at low speed",
    depends_on: &["velocity", "position", "history", "amplitude"],
    parameters: &[
        Parameter {
            name: "force_per_inertia", unit: "position unit/s²", default: None, range: NOT_NEGATIVE
        },
        Parameter { name: "extra_static", unit: "position unit/s²", default: None, range: NOT_NEGATIVE },
        Parameter {
            name: "stribeck_velocity",
            unit: "position unit/s",
            default: None,
            range: (f64::MIN_POSITIVE, f64::INFINITY),
        },
    ],
    build: |values, _| {
        Ok(Action::Force(Box::new(Lubricated {
            level: values["force_per_inertia"],
            extra: values["extra_static"],
            velocity: values["stribeck_velocity"],
        })))
    },
    draw: |strength, typical, generator| {
        let level = strength * typical.acceleration();
        vec![
            ("force_per_inertia", level),
            ("extra_static", level * uniform(generator, 0.5, 1.0)),
            ("stribeck_velocity", typical.velocity * uniform(generator, 0.1, 0.3)),
        ]
    },
};

#[derive(Debug)]
struct Lubricated {
    level: f64,
    extra: f64,
    velocity: f64,
}

impl Force for Lubricated {
    fn is_dry(&self) -> bool {
        true
    }

    fn friction(&self, at: &Motion, _: f64) -> f64 {
        self.level + self.extra * (-(at.v / self.velocity).powi(2)).exp()
    }
}
