//! What is known of an effect before it is injected.

use rand_chacha::ChaCha12Rng;

use super::{Action, Parameter};
use crate::values::Values;

/// In what an effect is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Context {
    /// Whether the recording was taken under feedback, so that the drive is what is predicted.
    pub feedback: bool,
}

/// Typical sizes of a motion, by which the strength of an effect is measured: root mean squares of a nominal
/// simulation, and what the mechanism is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Typical {
    /// Position.
    pub position: f64,
    /// Velocity.
    pub velocity: f64,
    /// Drive.
    pub drive: f64,
    /// Largest position.
    pub largest_position: f64,
    /// Largest drive.
    pub largest_drive: f64,
    /// Damping in 1/s.
    pub damping: f64,
    /// Stiffness in 1/s².
    pub stiffness: f64,
    /// Gain.
    pub gain: f64,
    /// The highest frequency that is excited, in Hz.
    pub highest_hz: f64,
    /// Time from sample to sample in seconds.
    pub sample_s: f64,
    /// Length of a run in seconds.
    pub duration_s: f64,
}

impl Typical {
    /// Acceleration by the drive alone, root mean square.
    pub fn acceleration(&self) -> f64 {
        self.gain * self.drive
    }

    /// The angular frequency by which lags and delays are measured: that of the mechanism itself, or, where
    /// it has no stiffness, of the highest excitation.
    pub fn corner_rad_per_s(&self) -> f64 {
        if self.stiffness > 0.0 { self.stiffness.sqrt() } else { std::f64::consts::TAU * self.highest_hz }
    }
}

/// Parameters by name.
pub type Drawn = Vec<(&'static str, f64)>;

/// What is known of an effect.
pub struct Specification {
    /// Its id; outside the table of effects it begins with `ooc_`.
    pub id: &'static str,
    /// What it is, in words.
    pub title: &'static str,
    /// The variables of which any may rightly be named as the place where it shows.
    pub depends_on: &'static [&'static str],
    /// Its parameters; units in words, since those of position and drive are the recording's.
    pub parameters: &'static [Parameter],
    /// How its part of the mechanism is made from its values.
    pub build: fn(&Values, &Context) -> Action,
    /// Draws its parameters at a strength: about the part of the drive's force, or of the position, that it
    /// makes up where the motion is typical.
    pub draw: fn(f64, &Typical, &mut ChaCha12Rng) -> Drawn,
}

impl Specification {
    /// Whether it stands in the table of effects.
    pub fn catalogued(&self) -> bool {
        !self.id.starts_with("ooc_")
    }
}

/// A number between two others.
pub(super) fn uniform(generator: &mut ChaCha12Rng, from: f64, to: f64) -> f64 {
    use rand::RngExt;
    from + (to - from) * generator.random::<f64>()
}

/// +1 or −1.
pub(super) fn sign(generator: &mut ChaCha12Rng) -> f64 {
    uniform(generator, -1.0, 1.0).signum()
}

/// Any number.
pub(super) const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
/// No negative one.
pub(super) const NOT_NEGATIVE: (f64, f64) = (0.0, f64::INFINITY);
/// Neither a negative one nor zero.
pub(super) const POSITIVE: (f64, f64) = (f64::MIN_POSITIVE, f64::INFINITY);
