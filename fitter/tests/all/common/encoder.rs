//! A simulated encoder on an eccentric scale, for tests: a true angle, a reading that is wrong by harmonics of
//! it, quantised, with friction and lag, against a reference.

use std::fmt::Write;

use fitter::coefficients::Reference;
use fitter::{Mirror, Recording, Sensor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::normal;

/// An encoder and its calibration.
pub struct Encoder {
    pub bits: u32,
    /// Amplitude in turns and phase in turns of the harmonics 1, 2 ….
    pub harmonics: Vec<(f64, f64)>,
    /// Offset of the zero in turns.
    pub zero: f64,
    /// By which the reading stays behind in either direction, in turns.
    pub friction: f64,
    pub lag_s: f64,
    /// Standard deviation of the reference in turns.
    pub noise: f64,
    /// Readings in a turn, and turns in each direction.
    pub readings: usize,
    pub turns: usize,
    /// Seconds from reading to reading, one entry for each pair of passes.
    pub step_s: Vec<f64>,
    pub backward: bool,
    /// Whether the reference counts on from turn to turn.
    pub reference_counts_turns: bool,
}

impl Encoder {
    pub fn eccentric(bits: u32) -> Encoder {
        Encoder {
            bits,
            harmonics: vec![(2.5e-3, 0.13), (4e-4, 0.61)],
            zero: 0.37,
            friction: 0.0,
            lag_s: 0.0,
            noise: 2e-6,
            readings: 200,
            turns: 2,
            step_s: vec![0.01],
            backward: true,
            reference_counts_turns: false,
        }
    }

    pub fn counts(&self) -> f64 {
        f64::from(1u32 << self.bits)
    }

    /// The reading in turns, before it is quantised.
    pub fn reading(&self, truth: f64) -> f64 {
        let waves = self.harmonics.iter().enumerate().map(|(k, (amplitude, phase))| {
            amplitude * (std::f64::consts::TAU * ((k as f64 + 1.0) * truth - phase)).cos()
        });
        truth + self.zero + waves.sum::<f64>()
    }

    /// The true angle in turns of a reading before it was quantised, by bisection.
    pub fn truth(&self, reading: f64) -> f64 {
        let (mut low, mut high) = (reading - self.zero - 0.1, reading - self.zero + 0.1);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.reading(middle) < reading { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// Rows of (t_s, pass, direction, measured in turns, reference in turns), the reading quantised.
    pub fn rows(&self, seed: u64) -> Vec<(f64, usize, i32, f64, f64)> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (mut rows, mut time, mut pass) = (Vec::new(), 0.0, 0);
        for step_s in &self.step_s {
            for direction in [1i32, -1] {
                if direction < 0 && !self.backward {
                    continue;
                }
                let count = self.turns * self.readings;
                let speed = f64::from(direction) / (self.readings as f64 * step_s);
                for index in 0..=count {
                    let index = if direction > 0 { index } else { count - index };
                    let truth = index as f64 / self.readings as f64;
                    let behind = f64::from(direction) * self.friction + self.lag_s * speed;
                    let reading = self.reading(truth) - behind;
                    let measured = (reading * self.counts()).floor().rem_euclid(self.counts());
                    let reference = truth + self.noise * normal(&mut random);
                    time += step_s;
                    let reference =
                        if self.reference_counts_turns { reference } else { reference.rem_euclid(1.0) };
                    rows.push((time, pass, direction, measured / self.counts(), reference));
                }
                pass += 1;
            }
        }
        rows
    }

    /// The recording as CSV, a turn being `revolution`.
    pub fn csv(&self, revolution: f64, seed: u64) -> String {
        let mut text = String::from("t_s,pass,direction,measured,reference\n");
        for (time, pass, direction, measured, reference) in self.rows(seed) {
            let (measured, reference) = (measured * revolution, reference * revolution);
            writeln!(text, "{time:.4},{pass},{direction},{measured:.9},{reference:.9}").unwrap();
        }
        text
    }

    pub fn recording(&self, revolution: f64, seed: u64) -> Recording {
        Recording::from_bytes("encoder.csv", self.csv(revolution, seed).as_bytes()).unwrap()
    }
}

pub fn turning(unit: &str, revolution: f64) -> Mirror {
    let sensor = Sensor::Direct { unit: unit.to_string(), revolution: Some(revolution) };
    Mirror { sensor, reference: Reference::default() }
}
