//! A plant with its numbers and effects, ready to be run on any drive.

use fitter::plant::{Hold, PlantEffect};

use super::effects::{Context, Typical};
use super::error::RunError;
use super::integrate::{Progress, check_steps, integrator};
use super::mechanism::{Instant, Mechanism, Mode};
use super::signal::{Edge, Signal};
use crate::values::EffectError;

/// One inertia on a spring and a damper with effects in it; see [`fitter::plant`] for the equations.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Damping per inertia in 1/s.
    pub damping: f64,
    /// Stiffness per inertia in 1/s².
    pub stiffness: f64,
    /// Gain of each drive per inertia.
    pub gains: Vec<f64>,
    /// What acts in it.
    pub effects: Vec<PlantEffect>,
    /// How the drives run between their samples.
    pub hold: Hold,
    /// In what the effects are meant.
    pub context: Context,
}

/// How a run begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// At a position with a velocity; 0 and 0 is at rest.
    At {
        /// In the position unit.
        position: f64,
        /// In the position unit per second.
        velocity: f64,
    },
    /// In the steady state that the first samples, repeated without end, lead to.
    Steady {
        /// Samples of a period.
        period: usize,
    },
}

/// At rest at position 0.
pub const REST: Start = Start::At { position: 0.0, velocity: 0.0 };

/// Periods after which a steady state that is not reached yet is given up and taken as it is.
const PERIODS: usize = 60;
/// Change of the state from one period to the next, relative to its typical size, that counts as steady.
const STEADY: f64 = 1e-7;

impl Model {
    /// A model that was checked: [`simulate`](Self::simulate) builds it again for every run.
    ///
    /// # Errors
    /// An effect that is not known or whose parameters make no sense.
    pub fn check(self) -> Result<Self, EffectError> {
        self.mechanism()?;
        Ok(self)
    }

    /// The same with other effects.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn with(&self, effects: Vec<PlantEffect>) -> Result<Self, EffectError> {
        Self { effects, ..self.clone() }.check()
    }

    /// Its equations, with nothing remembered.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn mechanism(&self) -> Result<Mechanism, EffectError> {
        Mechanism::new(self.damping, self.stiffness, self.gains.clone()).with(&self.effects, &self.context)
    }

    /// The read-out at every sample of the drives, which have their first sample at time 0.
    ///
    /// # Errors
    /// [`RunError`]: effects that make no sense, or a motion that runs away.
    pub fn simulate(&self, drives: &[Vec<f64>], sample_s: f64, start: Start) -> Result<Vec<f64>, RunError> {
        self.run(drives, sample_s, start, |mechanism, t_s, y, _| mechanism.read(t_s, y))
    }

    /// What reaches the mechanism of a drive, at every sample.
    pub(super) fn path(&self, drive: &[f64], sample_s: f64, start: Start) -> Result<Vec<f64>, RunError> {
        self.run(&[drive.to_vec()], sample_s, start, |mechanism, t_s, y, signals| {
            let instant = Instant { t_s, within_s: t_s + 0.25 * sample_s, mode: Mode::Free };
            mechanism.reaching(&instant, y, signals)
        })
    }

    /// Refuses a recording that is sampled so slowly that its simulation would not end.
    fn check_steps(&self, drives: &[Vec<f64>], sample_s: f64) -> Result<(), RunError> {
        let fastest = self.stiffness.abs().sqrt().max(self.damping.abs());
        check_steps(fastest, drives.first().map_or(0, Vec::len), sample_s)
    }

    fn run(
        &self,
        drives: &[Vec<f64>],
        sample_s: f64,
        start: Start,
        read: impl Fn(&Mechanism, f64, &[f64], &[Signal]) -> f64,
    ) -> Result<Vec<f64>, RunError> {
        self.check_steps(drives, sample_s)?;
        let count = drives.first().map_or(0, Vec::len);
        let mut mechanism = self.mechanism()?;
        let typical = Typical::of(self, drives, sample_s);
        let first: Vec<f64> = drives.iter().filter_map(|drive| drive.first().copied()).collect();
        let (position, velocity, edge, period) = match start {
            Start::At { position, velocity } => (position, velocity, Edge::Reflected, None),
            Start::Steady { period } => (0.0, 0.0, Edge::Periodic, Some(period.clamp(1, count.max(1)))),
        };
        let initial = Progress { t_s: 0.0, state: mechanism.at(position, velocity, &first) };
        let mut integrator = integrator(&mechanism, &typical, &initial)?;
        let signals = |samples: &[Vec<f64>], start_s: f64| -> Vec<Signal> {
            samples.iter().map(|u| Signal::new(u, start_s, sample_s, self.hold, edge)).collect()
        };
        // What came before the first sample is what comes at the end of the period.
        let ahead = |period: usize, upto: usize| -> Vec<Signal> {
            let longer: Vec<Vec<f64>> = drives.iter().map(|u| [&u[..period], &u[..upto]].concat()).collect();
            signals(&longer, -(period as f64) * sample_s)
        };
        if let Some(period) = period {
            let scales = mechanism.scales(&typical);
            // Two periods side by side, of which the second is integrated: delays reach into the first.
            let before = ahead(period, period);
            for round in 0..PERIODS {
                let earlier = integrator.progress();
                for index in 1..=period {
                    integrator.advance(&mut mechanism, &before, index as f64 * sample_s)?;
                }
                let mut now = integrator.progress();
                now.t_s = 0.0;
                let change = |((a, b), scale): ((&f64, &f64), &f64)| ((a - b) / scale).abs();
                let moved = now.state.iter().zip(&earlier.state).zip(&scales).map(change).fold(0.0, f64::max);
                integrator.place(&now);
                if moved < STEADY && round > 0 {
                    break;
                }
            }
        }
        let signals = period.map_or_else(|| signals(drives, 0.0), |period| ahead(period, count));
        let mut positions = Vec::with_capacity(count);
        for index in 0..count {
            if index > 0 {
                integrator.advance(&mut mechanism, &signals, index as f64 * sample_s)?;
            }
            let Progress { t_s, state } = integrator.progress();
            positions.push(read(&mechanism, t_s, &state, &signals));
        }
        Ok(positions)
    }

    /// Position and velocity at the first sample such that the first `rows` samples of the read-out come as
    /// close as they can to `recorded` (Gauss and Newton's method on two unknowns).
    ///
    /// # Errors
    /// As [`simulate`](Self::simulate).
    pub fn start_of(
        &self,
        drives: &[Vec<f64>],
        sample_s: f64,
        recorded: &[f64],
        rows: usize,
    ) -> Result<Start, RunError> {
        // Of the whole recording, not of its first rows alone.
        self.check_steps(drives, sample_s)?;
        let rows = rows.min(recorded.len());
        let begin: Vec<Vec<f64>> = drives.iter().map(|u| u[..rows.min(u.len())].to_vec()).collect();
        let run =
            |position: f64, velocity: f64| self.simulate(&begin, sample_s, Start::At { position, velocity });
        let typical = Typical::of(self, drives, sample_s);
        let spread = recorded[..rows].iter().fold(0.0f64, |most, y| most.max(y.abs())).max(typical.position);
        let steps = [1e-4 * spread, 1e-4 * spread / (rows.max(2) as f64 * sample_s)];
        let (mut position, mut velocity) = (recorded.first().copied().unwrap_or(0.0), 0.0);
        for _ in 0..6 {
            let base = run(position, velocity)?;
            let columns = [run(position + steps[0], velocity)?, run(position, velocity + steps[1])?];
            let slope = |column: usize, row: usize| (columns[column][row] - base[row]) / steps[column];
            let (mut a, mut b, mut c, mut p, mut q) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for row in 0..rows {
                let (s, t, e) = (slope(0, row), slope(1, row), recorded[row] - base[row]);
                a += s * s;
                b += s * t;
                c += t * t;
                p += s * e;
                q += t * e;
            }
            let determinant = a * c - b * b;
            if determinant <= 1e-12 * a * c {
                break;
            }
            position += (c * p - b * q) / determinant;
            velocity += (a * q - b * p) / determinant;
        }
        Ok(Start::At { position, velocity })
    }
}

impl Typical {
    /// Typical sizes of the motion of the bare mechanism of a model under drives.
    pub fn of(model: &Model, drives: &[Vec<f64>], sample_s: f64) -> Typical {
        let count = drives.first().map_or(0, Vec::len);
        let push = |index: usize| -> f64 {
            drives.iter().zip(&model.gains).map(|(u, gain)| gain * u.get(index).copied().unwrap_or(0.0)).sum()
        };
        let (k, d) = (model.stiffness, model.damping);
        // Steps short against the period and the damping, within reason.
        let fastest = k.abs().sqrt().max(d.abs());
        let parts = (4.0 * fastest * sample_s).ceil().clamp(1.0, 64.0);
        let step = sample_s / parts;
        let (mut x, mut v) = (0.0f64, 0.0f64);
        let mut typical = Typical {
            position: 0.0,
            velocity: 0.0,
            drive: 0.0,
            largest_position: 0.0,
            largest_drive: 0.0,
            damping: d,
            stiffness: k,
            gain: model.gains.first().copied().unwrap_or(1.0),
            highest_hz: 0.25 / sample_s,
            sample_s,
            duration_s: count as f64 * sample_s,
        };
        for index in 0..count {
            for drive in drives {
                let u = drive[index];
                typical.drive += u * u / (count * drives.len()) as f64;
                typical.largest_drive = typical.largest_drive.max(u.abs());
            }
            for _ in 0..parts as usize {
                // Symplectic Euler, damping implicit: rough, and never worse than the mechanism itself.
                v = (v + step * (push(index) - k * x)) / (1.0 + step * d.max(0.0));
                x += step * v;
            }
            if !(x.is_finite() && v.is_finite()) {
                break;
            }
            typical.position += x * x / count as f64;
            typical.velocity += v * v / count as f64;
            typical.largest_position = typical.largest_position.max(x.abs());
        }
        let or_one = |value: f64| if value.is_finite() && value > 0.0 { value } else { 1.0 };
        typical.position = or_one(typical.position.sqrt());
        typical.velocity = or_one(typical.velocity.sqrt());
        typical.drive = or_one(typical.drive.sqrt());
        typical.largest_drive = or_one(typical.largest_drive);
        typical.largest_position = or_one(typical.largest_position);
        typical
    }
}

#[cfg(test)]
mod tests;
