//! What is stepped through, how often and how fast, in which surroundings and with which noise.

use rand::RngExt;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

use crate::device::Device;
use crate::effects::EffectError;
use crate::noise::Noise;
use crate::streams::{Stream, stream};
use crate::temperature::Temperature;
use crate::units::round_to;

/// A calibration or verification protocol: passes over equidistant angles, forward and backward in turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Protocol {
    /// First and last commanded angle in degrees, first < last.
    pub range_deg: (f64, f64),
    /// Step between commanded angles in degrees; it divides the range.
    pub step_deg: f64,
    /// Number of passes; the first, third, … run forward (increasing angle), the others backward.
    pub passes: u32,
    /// How the mirror goes from one angle to the next.
    pub motion: Motion,
    /// Pause between passes in seconds.
    pub pause_s: f64,
    /// In which order the angles of a pass are visited.
    pub order: Order,
    /// The temperature of the base plate.
    pub temperature: Temperature,
    /// The kind of noise.
    pub noise: Noise,
}

/// How the mirror goes from one angle to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// It steps and settles before it is read.
    Stepped {
        /// Time from one reading to the next in seconds.
        dwell_s: f64,
        /// The time to settle varies by up to this much either way, in seconds.
        jitter_s: f64,
    },
    /// It moves evenly and is read as it passes each angle; the passes take these speeds in turn, in
    /// degrees of the commanded angle per second.
    Moving {
        /// Speeds in deg/s, at least one.
        speeds_deg_per_s: Vec<f64>,
    },
}

/// In which order the angles of a pass are visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// One after the other, forward and backward in turn.
    InTurn,
    /// Each pass in a random order of its own; `direction` is then that of the last move.
    Random,
}

/// One stop of a protocol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// When it is read, in seconds.
    pub t_s: f64,
    /// Number of the pass, from 1.
    pub pass: u32,
    /// +1 where the angle grew, −1 where it fell.
    pub direction: i8,
    /// Commanded angle in degrees.
    pub command_deg: f64,
    /// Speed of the command at the reading in deg/s; 0 where the mirror has settled.
    pub speed_deg_per_s: f64,
}

impl Protocol {
    /// The paper's calibration: the calculated angle over ±1.7° in steps of 0.1°, three passes forward and
    /// three backward, 210 readings.
    pub fn calibration() -> Self {
        Self {
            range_deg: (-1.7, 1.7),
            step_deg: 0.1,
            passes: 6,
            motion: Motion::Stepped { dwell_s: 3.0, jitter_s: 0.5 },
            pause_s: 30.0,
            order: Order::InTurn,
            temperature: Temperature::Laboratory,
            noise: Noise::White,
        }
    }

    /// The paper's verification: steps of 0.2°, three passes forward and three backward. The angles end at
    /// ±1.4°, so that a *corrected* angle that lands on them stays inside what the calibration covered
    /// (true angles −1.42° … +1.46°), noise included.
    pub fn verification() -> Self {
        Self { range_deg: (-1.4, 1.4), step_deg: 0.2, ..Self::calibration() }
    }

    /// A coarse calibration: steps of 0.2°, twelve passes, 216 readings.
    pub fn coarse() -> Self {
        Self { step_deg: 0.2, passes: 12, ..Self::calibration() }
    }

    /// A fine calibration: steps of 0.05°, eight passes, 552 readings.
    pub fn fine() -> Self {
        Self { step_deg: 0.05, passes: 8, ..Self::calibration() }
    }

    /// The paper's angles and passes in random order.
    pub fn random() -> Self {
        Self { order: Order::Random, ..Self::calibration() }
    }

    /// Read while the mirror moves: steps of 0.05°, twelve passes at three speeds both ways, 828 readings.
    pub fn scan() -> Self {
        let speeds_deg_per_s = vec![0.1, 0.1, 0.25, 0.25, 0.5, 0.5];
        Self {
            step_deg: 0.05,
            passes: 12,
            motion: Motion::Moving { speeds_deg_per_s },
            ..Self::calibration()
        }
    }

    /// The commanded angles of one forward pass in degrees, free of accumulated rounding.
    pub fn angles_deg(&self) -> Vec<f64> {
        let (first, last) = self.range_deg;
        let steps = ((last - first) / self.step_deg).round() as u32;
        (0..=steps).map(|i| first + f64::from(i) * self.step_deg).collect()
    }

    /// Every stop of the recording with this seed, in the order of time.
    pub fn stops(&self, seed: u64) -> Vec<Stop> {
        let mut timing = stream(seed, Stream::Timing);
        let mut shuffle = stream(seed, Stream::Order);
        let mut angles = self.angles_deg();
        let mut stops = Vec::with_capacity(angles.len() * self.passes as usize);
        let (mut t_s, mut last_deg) = (0.0, 0.0);
        for pass in 0..self.passes {
            if pass > 0 {
                t_s += self.pause_s;
                angles.reverse();
            }
            if self.order == Order::Random {
                angles.shuffle(&mut shuffle);
            }
            for &command_deg in &angles {
                let direction = match self.order {
                    Order::InTurn => 1 - 2 * (pass % 2) as i8,
                    Order::Random if command_deg >= last_deg => 1,
                    Order::Random => -1,
                };
                let speed_deg_per_s = match &self.motion {
                    Motion::Stepped { dwell_s, jitter_s } => {
                        t_s += dwell_s + timing.random_range(-jitter_s..=*jitter_s);
                        0.0
                    }
                    Motion::Moving { speeds_deg_per_s } => {
                        let speed = speeds_deg_per_s[pass as usize % speeds_deg_per_s.len()];
                        // The log is triggered by a clock of 10 ms; the command keeps to it.
                        let interval_s = round_to(self.step_deg / speed, 2).max(0.01);
                        t_s = round_to(t_s + interval_s, 2);
                        f64::from(direction) * self.step_deg / interval_s
                    }
                };
                stops.push(Stop { t_s, pass: pass + 1, direction, command_deg, speed_deg_per_s });
                last_deg = command_deg;
            }
        }
        stops
    }

    /// Whether every effect of the device can show at all under this protocol.
    ///
    /// # Errors
    /// A delay of the reference, where the mirror settles before it is read.
    pub fn suits(&self, device: &Device) -> Result<(), EffectError> {
        let settles = matches!(self.motion, Motion::Stepped { .. });
        match device.effects().find(|effect| settles && effect.needs_motion()) {
            Some(effect) => Err(EffectError::Settled { id: effect.id.clone() }),
            None => Ok(()),
        }
    }

    /// How long a recording takes in seconds, on average.
    pub fn duration_s(&self) -> f64 {
        let per_pass = self.angles_deg().len() as f64;
        let moving_s = match &self.motion {
            Motion::Stepped { dwell_s, .. } => f64::from(self.passes) * per_pass * dwell_s,
            Motion::Moving { speeds_deg_per_s } => (0..self.passes as usize)
                .map(|pass| per_pass * self.step_deg / speeds_deg_per_s[pass % speeds_deg_per_s.len()])
                .sum(),
        };
        moving_s + f64::from(self.passes.saturating_sub(1)) * self.pause_s
    }
}
