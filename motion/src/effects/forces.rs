//! Forces without states of their own: what they add to the acceleration, or take from the force of the drive.

use std::f64::consts::TAU;

use super::specification::{ANY, NOT_NEGATIVE, POSITIVE, sign, uniform};
use super::{Action, Force, Motion, Parameter, Specification};

/// A spring that hardens (c > 0) or softens: x″ −= c·x³, the odd part of a flexure whose blades are stretched
/// as they bend.
pub const CUBIC_STIFFNESS: Specification = Specification {
    id: "cubic_stiffness",
    title: "a spring that hardens or softens with the square of its deflection",
    depends_on: &["position", "amplitude", "acceleration"],
    parameters: &[Parameter::needed("coefficient", "1/(position unit² s²)", ANY)],
    build: |values, _| Action::force_by(values["coefficient"], |c, at| -c * at.x.powi(3)),
    draw: |strength, typical, generator| {
        // A softening spring still pulls back over the whole stroke.
        let limit = 0.3 * typical.stiffness / typical.largest_position.powi(2);
        let size = strength * typical.acceleration() / typical.position.powi(3);
        let soft = uniform(generator, 0.0, 1.0) < 0.25;
        vec![("coefficient", if soft { -size.min(limit) } else { size })]
    },
};

/// A spring that is stiffer on one side: x″ −= c·x², of a flexure that was mounted bent.
pub const QUADRATIC_STIFFNESS: Specification = Specification {
    id: "quadratic_stiffness",
    title: "a spring that is stiffer on one side",
    depends_on: &["position", "amplitude"],
    parameters: &[Parameter::needed("coefficient", "1/(position unit s²)", ANY)],
    build: |values, _| Action::force_by(values["coefficient"], |c, at| -c * at.x * at.x),
    draw: |strength, typical, generator| {
        // It still pulls back on the soft side.
        let limit = 0.3 * typical.stiffness / typical.largest_position;
        let size = strength * typical.acceleration() / typical.position.powi(2);
        vec![("coefficient", sign(generator) * size.min(limit))]
    },
};

/// Turbulent drag of the air that the plate moves: x″ −= c·v·|v|.
pub const QUADRATIC_DAMPING: Specification = Specification {
    id: "quadratic_damping",
    title: "drag with the square of the velocity",
    depends_on: &["velocity", "amplitude"],
    parameters: &[Parameter::needed("coefficient", "1/position unit", NOT_NEGATIVE)],
    build: |values, _| Action::force_by(values["coefficient"], |c, at| -c * at.v * at.v.abs()),
    draw: |strength, typical, _| {
        vec![("coefficient", strength * typical.acceleration() / typical.velocity.powi(2))]
    },
};

/// Damping that grows with the deflection: x″ −= c·x²·v, of a film of air squeezed at either end of the
/// stroke.
pub const NONLINEAR_DAMPING: Specification = Specification {
    id: "nonlinear_damping",
    title: "damping that grows with the deflection",
    depends_on: &["velocity", "position", "amplitude"],
    parameters: &[Parameter::needed("coefficient", "1/(position unit² s)", ANY)],
    build: |values, _| Action::force_by(values["coefficient"], |c, at| -c * at.x * at.x * at.v),
    draw: |strength, typical, _| {
        let moved = typical.position.powi(2) * typical.velocity;
        vec![("coefficient", strength * typical.acceleration() / moved)]
    },
};

/// Cogging of the magnets, or a thread: x″ −= A·sin(2πx/p + φ).
pub const COGGING: Specification = Specification {
    id: "cogging",
    title: "a force that repeats along the stroke",
    depends_on: &["position"],
    parameters: &[
        Parameter::needed("amplitude_per_inertia", "position unit/s²", ANY),
        Parameter::needed("period", "position unit", POSITIVE),
        Parameter::usual("phase_rad", "rad", 0.0, ANY),
    ],
    build: |values, _| {
        let (amplitude, phase_rad) = (values["amplitude_per_inertia"], values["phase_rad"]);
        let per_position = TAU / values["period"];
        Action::force(move |at| -amplitude * (per_position * at.x + phase_rad).sin())
    },
    draw: |strength, typical, generator| {
        let period = typical.position * uniform(generator, 0.7, 2.0);
        vec![
            ("amplitude_per_inertia", strength * typical.acceleration()),
            ("period", period),
            // Where the teeth stand is nobody's choice.
            ("phase_rad", uniform(generator, 0.0, TAU)),
        ]
    },
};

/// The coil leaves the field of its magnet: the gain is that at rest times 1 − δ·x².
pub const TORQUE_CONSTANT_DROOP: Specification = Specification {
    id: "torque_constant_droop",
    title: "a torque constant that droops towards the ends of the stroke",
    depends_on: &["position", "drive", "amplitude"],
    parameters: &[Parameter::needed("droop", "1/position unit²", ANY)],
    build: |values, _| Action::Force(Box::new(Coil { droop: values["droop"] })),
    draw: |strength, typical, _| {
        let limit = 0.8 / typical.largest_position.powi(2);
        vec![("droop", (strength / typical.position.powi(2)).min(limit))]
    },
};

struct Coil {
    droop: f64,
}

impl Force for Coil {
    fn drive_factor(&self, at: &Motion) -> f64 {
        1.0 - self.droop * at.x * at.x
    }
}

/// Outside the table: a flexure that fatigues, or an adhesive that cures, while it is recorded: x″ −= r·t·x.
pub const AGEING_STIFFNESS: Specification = Specification {
    id: "ooc_ageing_stiffness",
    title: "a stiffness that changes with time",
    depends_on: &["t_s"],
    parameters: &[Parameter::needed("stiffness_per_s", "1/s³", ANY)],
    build: |values, _| Action::force_by(values["stiffness_per_s"], |rate, at| -rate * at.t_s * at.x),
    draw: |strength, typical, generator| {
        let limit = 0.5 * typical.stiffness / typical.duration_s;
        let size = 2.0 * strength * typical.acceleration() / (typical.position * typical.duration_s);
        vec![("stiffness_per_s", sign(generator) * size.min(limit))]
    },
};

/// Outside the table: the field of the coils pulls on the iron of the mount, so that the stiffness depends on
/// the drive: x″ −= c·w·x.
pub const DRIVE_STIFFNESS: Specification = Specification {
    id: "ooc_drive_stiffness",
    title: "a stiffness that depends on the drive",
    depends_on: &["drive", "position"],
    parameters: &[Parameter::needed("coefficient", "1/(drive unit s²)", ANY)],
    build: |values, _| Action::force_by(values["coefficient"], |c, at| -c * at.drive * at.x),
    draw: |strength, typical, generator| {
        let limit = 0.5 * typical.stiffness / typical.largest_drive;
        let size = strength * typical.acceleration() / (typical.drive * typical.position);
        vec![("coefficient", sign(generator) * size.min(limit))]
    },
};

/// Outside the table: damping that is larger on one side than on the other, x″ −= c·x·v, of a magnet that is
/// not centred in its eddy-current damper.
pub const POSITION_DAMPING: Specification = Specification {
    id: "ooc_position_damping",
    title: "damping that changes its sign with the side",
    depends_on: &["velocity", "position"],
    parameters: &[Parameter::needed("coefficient", "1/(position unit s)", ANY)],
    build: |values, _| Action::force_by(values["coefficient"], |c, at| -c * at.x * at.v),
    draw: |strength, typical, generator| {
        // The mechanism stays damped over the whole stroke.
        let limit = 0.8 * typical.damping / typical.largest_position;
        let size = strength * typical.acceleration() / (typical.position * typical.velocity);
        vec![("coefficient", sign(generator) * size.min(limit))]
    },
};
