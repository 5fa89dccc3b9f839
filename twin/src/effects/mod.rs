//! The physics that can be hidden in a device, each effect acting where it acts in a real mirror, one file for each
//! place: between the frame and the mirror, in the bracket of the probes, in the probes, in the autocollimator.
//!
//! An effect is a [`Mechanism`]: hooks into the chain from the driven frame to the log. What it adds to the
//! angular error Δθ_M follows from the chain. With s the reported difference, ψ the rotation that the
//! probes see, φ that of the driven frame (which carries the pads) and Θ that of the mirror,
//!
//! Δθ_M(s) = Δθ(s) + (ψ − φ) + (φ − Θ) − (what the autocollimator adds),
//!
//! and a change δs of the reports adds δs·dΘ/ds. Parameters carry the names, units and signs of the
//! table of effects in the description of the file formats; ids that begin with `ooc_` are physics
//! outside that table.
//!
//! To add an effect: its specification in the file of its place, and one line in [`catalogue::ALL`].

pub mod catalogue;
mod injected;
mod specification;

mod autocollimator;
mod bracket;
mod frame;
mod probes;
mod simple;

pub use catalogue::{draw, find};
pub use injected::Injected;
pub use motion::values::{EffectError, Known, Values};
use simple::{read, reported, seen};
pub use specification::{Build, Drawn, Made, Parameter, Scope, Specification};

/// Where everything stands at one reading, or would stand at an angle that the loop tries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Time in seconds.
    pub t_s: f64,
    /// Number of the pass, from 1.
    pub pass: u32,
    /// +1 where the mirror came from smaller angles, −1 from larger ones.
    pub direction: f64,
    /// Temperature of the base plate in °C.
    pub temperature_c: f64,
    /// Common-mode translation of the plate in millimetres.
    pub translation_mm: f64,
    /// φ, the angle of the driven frame that carries the pads, in radians.
    pub frame_rad: f64,
    /// Θ, the true angle of the mirror, in radians.
    pub mirror_rad: f64,
    /// Coil current in A.
    pub coil_a: f64,
    /// Rotation about the second axis in arcseconds.
    pub cross_arcsec: f64,
}

/// The chain from the driven frame to the log, where an effect acts. Nothing acts by default.
///
/// The loop tries many angles before it settles: everything but [`advance`](Self::advance) and
/// [`settled`](Self::settled) is a pure function of the pose and of what was remembered.
pub trait Mechanism: Afresh + Send + Sync {
    /// Time has come to that of the pose, which still stands at its last angles.
    fn advance(&mut self, _pose: &Pose) {}

    /// φ − Θ: how far the frame stands ahead of the mirror, in radians, having come straight from where it
    /// last settled.
    fn lost_motion_rad(&self, _frame_rad: f64) -> f64 {
        0.0
    }

    /// ψ − φ: what the probes see as rotation beyond that of the frame, in radians.
    fn seen_rotation_rad(&self, _pose: &Pose) -> f64 {
        0.0
    }

    /// The distance between the probes, relative to its nominal value.
    fn probe_distance(&self, _pose: &Pose) -> f64 {
        1.0
    }

    /// Changes what the two probes report, in millimetres.
    fn report(&self, _pose: &Pose, _reports_mm: &mut [f64; 2]) {}

    /// What the autocollimator reads beyond the mirror's angle, in arcseconds.
    fn reference_arcsec(&self, _pose: &Pose) -> f64 {
        0.0
    }

    /// How long after the probes the autocollimator looks back, in seconds: it reads the angle of then.
    fn reference_delay_s(&self) -> f64 {
        0.0
    }

    /// The mirror has settled.
    fn settled(&mut self, _pose: &Pose) {}
}

/// A mechanism as it is before a recording, ready to be started.
pub trait Afresh {
    /// A copy that remembers nothing.
    fn afresh(&self) -> Box<dyn Mechanism>;
}

impl<M: Mechanism + Clone + 'static> Afresh for M {
    fn afresh(&self) -> Box<dyn Mechanism> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
