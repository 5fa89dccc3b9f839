//! A mechanism in motion with physics that stands in no table of effects, integrated here in short steps of fixed
//! length: nothing of it is shared with how a plant file is run.

use std::f64::consts::{SQRT_2, TAU};

use rand::RngExt;

use super::bench::{Bench, DECIMALS};
use crate::noise::Source;
use crate::sensor::Uniform;
use crate::streams::{Stream, stream};
use crate::units::round_to;

/// Steps of the integration between two samples.
const STEPS: usize = 8;

/// Where the mechanism stands, each in units of its root mean square in the motion without effects.
#[derive(Debug, Clone, Copy)]
pub struct Instant {
    /// Length of the step in seconds.
    pub step_s: f64,
    /// Position.
    pub x: f64,
    /// Velocity.
    pub v: f64,
    /// Drive.
    pub u: f64,
    /// The preload, in parts of its range about its middle, from −1 to 1.
    pub preload: f64,
}

/// What a mechanism adds to the acceleration, in units of the drive's own. The first argument tells it that a step begins,
/// in which its states change; else it is only asked.
pub type Physics = Box<dyn FnMut(bool, &Instant) -> f64 + Send>;

/// A kind of physics in motion.
pub struct Kind {
    /// Its id.
    pub id: &'static str,
    /// What it is.
    pub title: &'static str,
    /// The variables of which any may rightly be named as the place where it shows.
    pub depends_on: &'static [&'static str],
    /// Draws the numbers that shape it.
    pub shape: fn(Uniform) -> Vec<f64>,
    /// Makes it, so strong: about the part of the drive's force that it makes up.
    pub build: fn(&[f64], f64) -> Physics,
}

/// One without memory and numbers.
macro_rules! plain {
    ($id:literal, $title:literal, $depends_on:expr, |$at:ident| $force:expr) => {
        Kind {
            id: $id,
            title: $title,
            depends_on: $depends_on,
            shape: |_| Vec::new(),
            build: |_, strength| Box::new(move |_, $at| strength * $force),
        }
    };
}

/// All kinds. Products of normal deviates are divided by their root mean square.
pub const ALL: &[Kind] = &[
    plain!(
        "ooc_fifth_power",
        "blades that stretch and buckle: the fifth power of the deflection",
        &["position", "amplitude"],
        |at| -at.x.powi(5) / 30.7
    ),
    plain!(
        "ooc_centripetal",
        "a mass off the axis: position times the square of the velocity",
        &["position", "velocity"],
        |at| -at.x * at.v * at.v / 1.73
    ),
    plain!(
        "ooc_eddy_brake",
        "the coil's field brakes a copper plate: the square of the drive times the velocity",
        &["drive", "velocity"],
        |at| -at.u * at.u * at.v / 1.73
    ),
    plain!("ooc_even_drive", "an amplifier with a second harmonic", &["drive", "frequency_hz"], |at| (at.u
        * at.u
        - 1.0)
        / SQRT_2),
    plain!("ooc_one_way_drag", "a lip seal that drags in one direction", &["velocity", "direction"], |at| {
        -at.v.max(0.0)
    }),
    plain!(
        "ooc_preload_spring",
        "a stiffness that goes with the preload of its bearing",
        &["preload_n", "position", "t_s"],
        |at| -at.preload * at.x
    ),
    Kind {
        id: "ooc_crossover",
        title: "an amplifier whose halves do not overlap",
        depends_on: &["drive", "amplitude"],
        shape: |_| Vec::new(),
        build: |_, strength| Box::new(move |_, at| -at.u.clamp(-strength, strength)),
    },
    Kind {
        id: "ooc_rate_limit",
        title: "an amplifier whose output rises no faster than it can",
        depends_on: &["drive", "frequency_hz", "amplitude"],
        shape: |_| Vec::new(),
        build: |_, strength| {
            let per_s = TAU * 120.0 * (0.1 / strength.max(1e-6)).sqrt();
            let mut output = 0.0;
            Box::new(move |begins, at| {
                if begins {
                    let most = per_s * at.step_s;
                    output += (at.u - output).clamp(-most, most);
                }
                output - at.u
            })
        },
    },
    Kind {
        id: "ooc_coil_fade",
        title: "a torque constant that fades as the coil heats up",
        depends_on: &["drive", "t_s", "history"],
        shape: |uniform| vec![uniform(0.15, 0.6)],
        build: |shape, strength| {
            let (time_constant_s, mut heat) = (shape[0], 0.0);
            Box::new(move |begins, at| {
                if begins {
                    heat += (at.u * at.u - heat) * at.step_s / time_constant_s;
                }
                -3.0 * strength * heat * at.u
            })
        },
    },
    Kind {
        id: "ooc_bumper",
        title: "a rubber bumper on one side",
        depends_on: &["position", "amplitude"],
        shape: |uniform| vec![uniform(0.3, 1.0)],
        build: |shape, strength| {
            let from = shape[0];
            Box::new(move |_, at| -4.0 * strength * (at.x - from).max(0.0))
        },
    },
    Kind {
        id: "ooc_detents",
        title: "detents at a few places of the stroke",
        depends_on: &["position"],
        shape: |uniform| (0..4).flat_map(|_| [uniform(-1.6, 1.6), uniform(-2.5, 2.5)]).collect(),
        build: |shape, strength| {
            let detents: Vec<(f64, f64)> = shape.chunks(2).map(|pair| (pair[0], pair[1])).collect();
            Box::new(move |_, at| {
                let pull = |(place, size): &(f64, f64)| size * (-0.5 * ((at.x - place) / 0.15).powi(2)).exp();
                strength * detents.iter().map(pull).sum::<f64>()
            })
        },
    },
];

/// The kind with this id.
pub fn find(id: &str) -> Option<&'static Kind> {
    ALL.iter().find(|kind| kind.id == id)
}

/// A mechanism with a kind of physics in it.
pub struct Rig {
    /// The mechanism, its excitation and its noise.
    pub bench: Bench,
    kind: &'static Kind,
    /// The numbers that shape the physics.
    pub shape: Vec<f64>,
    /// Root mean square of position, velocity and drive without it.
    scales: [f64; 3],
}

/// Damping, stiffness, gain, and how strong the physics is.
pub type Numbers = [f64; 4];

impl Rig {
    /// The mechanism of a bench with a kind of physics, shaped by `seed`.
    pub fn new(bench: Bench, kind: &'static Kind, seed: u64) -> Self {
        let mut generator = stream(seed, Stream::Sensor);
        let mut uniform = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
        let shape = (kind.shape)(&mut uniform);
        let typical = bench.typical(seed);
        let scales = [typical.position, typical.velocity, typical.drive];
        Self { bench, kind, shape, scales }
    }

    /// Its own numbers, with a strength.
    pub fn numbers(&self, strength: f64) -> Numbers {
        let model = &self.bench.model;
        [model.damping, model.stiffness, model.gains.first().copied().unwrap_or(1.0), strength]
    }

    /// The preload over a recording: half a cycle to two and a half.
    pub fn preload(&self, seed: u64) -> Vec<f64> {
        let mut generator = stream(seed, Stream::Surroundings(0));
        let (cycles, phase) = (generator.random_range(0.5..2.5), generator.random_range(0.0..TAU));
        let count = self.bench.samples;
        (0..count).map(|k| (TAU * cycles * k as f64 / count as f64 + phase).sin()).collect()
    }

    /// The position at every sample of a drive that is held between them, from rest (Runge and Kutta's method of the
    /// fourth order). Not finite where it runs away.
    pub fn positions(&self, numbers: &Numbers, drive: &[f64], preload: &[f64]) -> Vec<f64> {
        let [damping, stiffness, gain, strength] = *numbers;
        let [position, velocity, driven] = self.scales;
        let acceleration = self.numbers(0.0)[2] * driven;
        let mut physics = (self.kind.build)(&self.shape, strength);
        let step_s = self.bench.sample_s / STEPS as f64;
        let (mut x, mut v) = (0.0, 0.0);
        let mut positions = Vec::with_capacity(drive.len());
        for (u, preload) in drive.iter().zip(preload) {
            positions.push(x);
            let mut rate = |begins: bool, x: f64, v: f64| {
                let at =
                    Instant { step_s, x: x / position, v: v / velocity, u: u / driven, preload: *preload };
                gain * u - damping * v - stiffness * x + acceleration * physics(begins, &at)
            };
            for _ in 0..STEPS {
                let h = step_s;
                let (v1, a1) = (v, rate(true, x, v));
                let (v2, a2) = (v + 0.5 * h * a1, rate(false, x + 0.5 * h * v1, v + 0.5 * h * a1));
                let (v3, a3) = (v + 0.5 * h * a2, rate(false, x + 0.5 * h * v2, v + 0.5 * h * a2));
                let (v4, a4) = (v + h * a3, rate(false, x + h * v3, v + h * a3));
                x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
                v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
            }
        }
        positions
    }

    /// Noise of the read-out, and the position as it is logged with it.
    pub fn read_out(&self, clean: &[f64], seed: u64) -> Vec<f64> {
        let bench = &self.bench;
        let mut source = Source::start(&bench.noise, 1, stream(seed, Stream::ReadOut(1)));
        let noisy =
            |(row, x): (usize, &f64)| x + bench.noise_arcsec * source.draw(0, row as f64 * bench.sample_s);
        clean.iter().enumerate().map(noisy).map(|x| round_to(x, DECIMALS[2] as i32)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rms(values: impl Iterator<Item = f64> + Clone) -> f64 {
        (values.clone().map(|v| v * v).sum::<f64>() / values.count() as f64).sqrt()
    }

    #[test]
    fn without_strength_it_is_the_mechanism_and_with_it_every_kind_shows() {
        for (seed, kind) in ALL.iter().enumerate() {
            let mut bench = Bench { samples: 2048, ..Bench::from_seed(seed as u64) };
            bench.model.hold = fitter::plant::Hold::ZeroOrder;
            let rig = Rig::new(bench, kind, 4);
            let (drive, preload) = (rig.bench.drive(9, 0), rig.preload(9));
            let run = |strength| rig.positions(&rig.numbers(strength), &drive, &preload);
            let (without, with) = (run(1e-9), run(0.05));
            let added = rms(with.iter().zip(&without).map(|(a, b)| a - b));
            assert!(added > rig.bench.noise_arcsec && added.is_finite(), "{}: {added}", kind.id);
            assert_eq!(with, run(0.05), "{}", kind.id);
            if kind.id == "ooc_even_drive" {
                // The integration of the other room.
                let clean = rig.bench.record_noiseless(9).unwrap();
                let apart = rms(clean.positions[0].iter().zip(&without).map(|(a, b)| a - b));
                assert!(apart < 1e-3 * rms(without.iter().copied()), "{apart}");
            }
        }
    }
}
