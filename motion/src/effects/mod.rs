//! The physics that can be hidden in a moving mechanism, each acting where it acts in a real one: between the
//! recorded drive and the force, as a force on the inertia, or in the read-out.
//!
//! Parameters and equations are those of the table in [`fitter::plant`]; ids that begin with `ooc_` are
//! physics outside that table. To add an effect: its specification in `forces`, `friction` or `path`, or in a file of
//! its own where it has states or remembers, and one line in [`catalogue::ALL`].

use super::signal::Flow;

pub mod catalogue;
mod specification;

mod bouc_wen_hysteresis;
mod flexible_mode;
mod forces;
mod friction;
mod ooc_sticking_stop;
mod path;
mod rayleigh_hysteresis;

pub use crate::values::Known as Parameter;
pub use catalogue::find;
pub use specification::{Context, Drawn, Specification, Typical};

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

/// What stands on the way of a drive to the mechanism, or of the position to its recording.
pub trait Element: Send + Sync {
    /// By how much it delays, in seconds. Delays come before everything else.
    fn delay_s(&self) -> f64 {
        0.0
    }

    /// How many states of its own it has.
    fn states(&self) -> usize {
        0
    }

    /// What comes out where `input` goes in, at `t_s`; the rates of its own states go into `rates`.
    fn pass(&self, _t_s: f64, input: Flow, _own: &[f64], _rates: &mut [f64]) -> Flow {
        input
    }

    /// Whether it remembers where its input turned round: the integration then pauses at every turn.
    fn remembers_turns(&self) -> bool {
        false
    }

    /// The input has come to this value, monotonously since the last call.
    fn remember(&mut self, _input: f64) {}
}

/// A force on the inertia, per inertia.
pub trait Force: Send + Sync {
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

/// What an effect is in the mechanism.
pub enum Action {
    /// On the way of each drive.
    Drive(Box<dyn Element>),
    /// A force.
    Force(Box<dyn Force>),
    /// In the read-out.
    ReadOut(Box<dyn Element>),
}

impl Action {
    /// Each drive without memory: what it becomes at a time in seconds.
    fn drive(passes: impl Fn(f64, Flow) -> Flow + Send + Sync + 'static) -> Action {
        Action::Drive(Box::new(AtOnce(passes)))
    }

    /// The read-out, likewise.
    fn read_out(passes: impl Fn(f64, Flow) -> Flow + Send + Sync + 'static) -> Action {
        Action::ReadOut(Box::new(AtOnce(passes)))
    }

    /// A force without memory: what it adds to the acceleration.
    fn force(acceleration: impl Fn(&Motion) -> f64 + Send + Sync + 'static) -> Action {
        Action::Force(Box::new(Plain(acceleration)))
    }

    /// The same with a number of its own.
    fn force_by(number: f64, acceleration: impl Fn(f64, &Motion) -> f64 + Send + Sync + 'static) -> Action {
        Action::force(move |at| acceleration(number, at))
    }

    /// Dry friction, as [`Force::friction`] has it.
    fn friction(friction: impl Fn(&Motion, f64) -> f64 + Send + Sync + 'static) -> Action {
        Action::Force(Box::new(Dry(friction)))
    }
}

struct AtOnce<F>(F);

impl<F: Fn(f64, Flow) -> Flow + Send + Sync> Element for AtOnce<F> {
    fn pass(&self, t_s: f64, input: Flow, _: &[f64], _: &mut [f64]) -> Flow {
        self.0(t_s, input)
    }
}

struct Plain<F>(F);

impl<F: Fn(&Motion) -> f64 + Send + Sync> Force for Plain<F> {
    fn acceleration(&self, at: &Motion, _: &[f64], _: &mut [f64]) -> f64 {
        self.0(at)
    }
}

struct Dry<F>(F);

impl<F: Fn(&Motion, f64) -> f64 + Send + Sync> Force for Dry<F> {
    fn is_dry(&self) -> bool {
        true
    }

    fn friction(&self, at: &Motion, direction: f64) -> f64 {
        self.0(at, direction)
    }
}

#[cfg(test)]
mod tests;
