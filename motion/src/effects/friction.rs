//! Dry friction: against the motion whatever its speed; at rest it holds against any smaller force.

use super::specification::{ANY, NOT_NEGATIVE, POSITIVE, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

/// Dry friction (Coulomb): F against the motion; at rest it holds against any force up to F.
pub const COULOMB: Specification = Specification {
    id: "coulomb_friction",
    title: "dry friction",
    depends_on: &["velocity", "position", "history", "amplitude"],
    parameters: &[Parameter::needed("force_per_inertia", "position unit/s²", NOT_NEGATIVE)],
    build: |values, _| {
        let level = values["force_per_inertia"];
        Action::friction(move |_, _| level)
    },
    draw: |strength, typical, _| vec![("force_per_inertia", strength * typical.acceleration())],
};

/// Dry friction that falls as a film of oil builds up (Stribeck): F + E·exp(−|v/v_s|ᵟ) against the motion; at
/// rest it holds up to F + E. Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), 1083–1138.
pub const STRIBECK: Specification = Specification {
    id: "stribeck_friction",
    title: "dry friction that is larger at low speed",
    depends_on: &["velocity", "position", "history", "amplitude"],
    parameters: &[
        Parameter::needed("force_per_inertia", "position unit/s²", NOT_NEGATIVE),
        Parameter::needed("extra_static", "position unit/s²", NOT_NEGATIVE),
        Parameter::needed("stribeck_velocity", "position unit/s", POSITIVE),
        Parameter::usual("exponent", "1", 2.0, (0.5, 2.0)),
    ],
    build: |values, _| {
        let (level, extra) = (values["force_per_inertia"], values["extra_static"]);
        let (velocity, exponent) = (values["stribeck_velocity"], values["exponent"]);
        Action::friction(move |at, _| level + extra * (-(at.v / velocity).abs().powf(exponent)).exp())
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

/// More friction at one place, as of a worn stretch of a guide: F·exp(−((x − c)/w)²) against the motion.
pub const LOCAL: Specification = Specification {
    id: "local_friction",
    title: "dry friction at one place",
    depends_on: &["position", "velocity"],
    parameters: &[
        Parameter::needed("force_per_inertia", "position unit/s²", NOT_NEGATIVE),
        Parameter::needed("centre", "position unit", ANY),
        Parameter::needed("width", "position unit", POSITIVE),
    ],
    build: |values, _| {
        let (level, centre, width) = (values["force_per_inertia"], values["centre"], values["width"]);
        Action::friction(move |at, _| level * (-((at.x - centre) / width).powi(2)).exp())
    },
    draw: |strength, typical, generator| {
        vec![
            ("force_per_inertia", 2.0 * strength * typical.acceleration()),
            ("centre", typical.position * uniform(generator, -0.7, 0.7)),
            ("width", typical.position * uniform(generator, 0.2, 0.5)),
        ]
    },
};

/// Friction beyond a play: what is driven through a worn screw, gear or coupling stands still while the play is crossed,
/// and F less is against the motion.
pub const BACKLASH: Specification = Specification {
    id: "backlash",
    title: "friction beyond a play",
    depends_on: &["history", "velocity"],
    parameters: &[
        Parameter::needed("friction_beyond", "position unit/s²", NOT_NEGATIVE),
        Parameter::needed("play", "position unit", POSITIVE),
    ],
    build: |values, _| {
        let (beyond, half) = (values["friction_beyond"], 0.5 * values["play"]);
        Action::Force(Box::new(BeyondPlay { beyond, half, middle: None }))
    },
    draw: |strength, typical, generator| {
        vec![
            ("friction_beyond", strength * typical.acceleration()),
            ("play", typical.position * uniform(generator, 0.5, 1.0)),
        ]
    },
};

struct BeyondPlay {
    beyond: f64,
    /// Half of the play.
    half: f64,
    /// The middle of the play where it stands.
    middle: Option<f64>,
}

impl Force for BeyondPlay {
    fn is_dry(&self) -> bool {
        true
    }

    fn friction(&self, at: &Motion, direction: f64) -> f64 {
        let off = at.x - self.middle.unwrap_or(at.x);
        if off * direction >= self.half { 0.0 } else { -self.beyond }
    }

    fn remember(&mut self, at: &Motion) {
        let middle = self.middle.get_or_insert(at.x);
        *middle = middle.clamp(at.x - self.half, at.x + self.half);
    }
}

/// Outside the table: a seal that is folded over drags in one direction only, and the more the further it is
/// stretched: F·(1 + x/x₀), not below 0, against forward motion.
pub const ASYMMETRIC: Specification = Specification {
    id: "ooc_asymmetric_friction",
    title: "dry friction of one direction that grows along the stroke",
    depends_on: &["velocity", "position"],
    parameters: &[
        Parameter::needed("force_per_inertia", "position unit/s²", NOT_NEGATIVE),
        Parameter::needed("position_scale", "position unit", POSITIVE),
    ],
    build: |values, _| {
        let (level, scale) = (values["force_per_inertia"], values["position_scale"]);
        let forward = move |x: f64| (level * (1.0 + x / scale)).max(0.0);
        Action::friction(move |at, direction| if direction > 0.0 { forward(at.x) } else { 0.0 })
    },
    draw: |strength, typical, generator| {
        vec![
            ("force_per_inertia", 2.0 * strength * typical.acceleration()),
            ("position_scale", typical.position * uniform(generator, 0.6, 1.2)),
        ]
    },
};
