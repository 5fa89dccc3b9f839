//! The physics that can be hidden in a moving mechanism: one file per effect, each acting where it acts in a
//! real one — between the recorded drive and the force, as a force on the inertia, or in the read-out.
//!
//! Parameters and equations are those of the table in [`fitter::plant`]; ids that begin with `ooc_` are
//! physics outside that table. To add an effect: one file here, and one line in [`catalogue::ALL`].

use std::fmt::Debug;

use super::signal::Flow;

pub mod catalogue;
mod specification;

mod bouc_wen_hysteresis;
mod cogging;
mod coulomb_friction;
mod cubic_stiffness;
mod drive_lag;
mod drive_offset;
mod drive_saturation;
mod flexible_mode;
mod nonlinear_damping;
mod ooc_ageing_stiffness;
mod ooc_asymmetric_friction;
mod ooc_dead_zone;
mod ooc_drive_stiffness;
mod ooc_mains_hum;
mod ooc_position_damping;
mod ooc_sticking_stop;
mod quadratic_damping;
mod quadratic_stiffness;
mod rayleigh_hysteresis;
mod sensor_lag;
mod sensor_offset;
mod stribeck_friction;
mod torque_constant_droop;
mod transport_delay;

pub use catalogue::find;
pub use specification::{Context, Drawn, Parameter, Specification, Typical};

/// Where the mechanism is, and what drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Time in seconds.
    pub t_s: f64,
    /// Position x, in the position unit.
    pub x: f64,
    /// Velocity v, in the position unit per second.
    pub v: f64,
    /// The drive that reaches the mechanism, the first where there are several, in the drive unit.
    pub drive: f64,
}

/// What stands between the recorded drive and the mechanism; one of them for each drive.
pub trait DriveElement: Debug + Send + Sync {
    /// By how much it delays, in seconds. Delays come before everything else.
    fn delay_s(&self) -> f64 {
        0.0
    }

    /// How many states of its own it has.
    fn states(&self) -> usize {
        0
    }

    /// What comes out where `drive` goes in, at `t_s`; the rates of its own states go into `rates`.
    fn pass(&self, _t_s: f64, drive: Flow, _own: &[f64], _rates: &mut [f64]) -> Flow {
        drive
    }

    /// Whether it remembers where its input turned round: the integration then pauses at every turn.
    fn remembers_turns(&self) -> bool {
        false
    }

    /// The input has come to this value, monotonously since the last call.
    fn remember(&mut self, _input: f64) {}
}

/// A force on the inertia, per inertia.
pub trait Force: Debug + Send + Sync {
    /// How many states of its own it has.
    fn states(&self) -> usize {
        0
    }

    /// The size that its states typically have.
    fn scales(&self, typical: &Typical) -> Vec<f64> {
        vec![typical.position; self.states()]
    }

    /// The factor on the force of the drive.
    fn drive_factor(&self, _at: &Motion) -> f64 {
        1.0
    }

    /// What it adds to the acceleration; the rates of its own states go into `rates`.
    fn acceleration(&self, _at: &Motion, _own: &[f64], _rates: &mut [f64]) -> f64 {
        0.0
    }

    /// Whether it is dry friction.
    fn is_dry(&self) -> bool {
        false
    }

    /// Dry friction per inertia, against a motion in `direction` (±1) or, at rest, against a force that way.
    fn friction(&self, _at: &Motion, _direction: f64) -> f64 {
        0.0
    }

    /// The mechanism has come here.
    fn remember(&mut self, _at: &Motion) {}
}

/// What stands between the position and the recording of it.
pub trait ReadOut: Debug + Send + Sync {
    /// How many states of its own it has.
    fn states(&self) -> usize {
        0
    }

    /// What is read where the position is `position`; the rates of its own states go into `rates`.
    fn read(&self, position: f64, _own: &[f64], _rates: &mut [f64]) -> f64 {
        position
    }
}

/// What an effect is in the mechanism.
#[derive(Debug)]
pub enum Action {
    /// On the way of each drive.
    Drive(Box<dyn DriveElement>),
    /// A force.
    Force(Box<dyn Force>),
    /// In the read-out.
    ReadOut(Box<dyn ReadOut>),
}

#[cfg(test)]
mod tests;
