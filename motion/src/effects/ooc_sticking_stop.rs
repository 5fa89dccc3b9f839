//! Outside the table: a rubber stop at one end of the stroke, which sticks: beyond x_s it pushes back with a
//! contact stiffness, and once touched it pulls until the mirror has come away by a gap.

use super::specification::{ANY, NOT_NEGATIVE, POSITIVE, sign, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

pub const SPECIFICATION: Specification = Specification {
    id: "ooc_sticking_stop",
    title: "a stop that sticks",
    depends_on: &["position", "history"],
    parameters: &[
        Parameter::needed("stop", "position unit", ANY),
        Parameter::needed("contact_stiffness", "1/s²", NOT_NEGATIVE),
        Parameter::needed("adhesion_per_inertia", "position unit/s²", NOT_NEGATIVE),
        Parameter::needed("gap", "position unit", POSITIVE),
    ],
    build: |values, _| {
        Action::Force(Box::new(Stop {
            at: values["stop"],
            stiffness: values["contact_stiffness"],
            adhesion: values["adhesion_per_inertia"],
            gap: values["gap"],
            touched: false,
        }))
    },
    draw: |strength, typical, generator| {
        let side = sign(generator);
        let stop = side * typical.largest_position * uniform(generator, 0.35, 0.6);
        vec![
            ("stop", stop),
            ("contact_stiffness", 10.0 * strength * typical.acceleration() / typical.position),
            ("adhesion_per_inertia", 3.0 * strength * typical.acceleration()),
            ("gap", 0.15 * typical.position),
        ]
    },
};

struct Stop {
    at: f64,
    stiffness: f64,
    adhesion: f64,
    gap: f64,
    touched: bool,
}

impl Stop {
    /// How far the mirror is beyond the stop.
    fn beyond(&self, x: f64) -> f64 {
        (x - self.at) * self.at.signum()
    }
}

impl Force for Stop {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        let beyond = self.beyond(at.x);
        let push = self.stiffness * beyond.max(0.0);
        let away = (-beyond / self.gap).clamp(0.0, 1.0);
        // Nothing at the stop itself and nothing a gap away from it: the pull neither jumps nor bends hard.
        let pull = if self.touched { self.adhesion * (std::f64::consts::PI * away).sin() } else { 0.0 };
        (pull - push) * self.at.signum()
    }

    fn remember(&mut self, at: &Motion) {
        let beyond = self.beyond(at.x);
        self.touched = beyond > 0.0 || (self.touched && beyond > -self.gap);
    }
}
