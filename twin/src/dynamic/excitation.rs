//! What a mechanism is driven with: multisines, sweeps, steps.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

/// A kind of excitation; the highest frequencies in Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Excitation {
    /// A sum of cosines of equal amplitude and random phase (Pintelon and Schoukens, *System Identification: A
    /// Frequency Domain Approach*, section 4.2).
    Multisine {
        /// Up to which frequency, in Hz.
        highest_hz: f64,
        /// Only odd multiples of the lowest frequency, and of every four of them one, drawn at random, left
        /// out: on the free lines even and odd distortions show.
        odd: bool,
    },
    /// A sine whose frequency grows evenly.
    Sweep {
        /// From, in Hz.
        lowest_hz: f64,
        /// To, in Hz.
        highest_hz: f64,
    },
    /// Levels drawn at random, each held as long.
    Steps {
        /// How long, in seconds.
        hold_s: f64,
    },
}

impl Excitation {
    /// The highest frequency that it is meant to excite, in Hz.
    pub fn highest_hz(&self) -> f64 {
        match *self {
            Self::Multisine { highest_hz, .. } | Self::Sweep { highest_hz, .. } => highest_hz,
            Self::Steps { hold_s } => 0.5 / hold_s,
        }
    }

    /// `count` samples of root mean square 1; a multisine has them as its period.
    pub fn samples(&self, count: usize, sample_s: f64, generator: &mut ChaCha12Rng) -> Vec<f64> {
        let mut samples = match *self {
            Self::Multisine { highest_hz, odd } => multisine(count, sample_s, highest_hz, odd, generator),
            Self::Sweep { lowest_hz, highest_hz } => {
                let duration_s = count as f64 * sample_s;
                let growth = (highest_hz - lowest_hz) / duration_s;
                let phase = |t: f64| std::f64::consts::TAU * (lowest_hz + 0.5 * growth * t) * t;
                (0..count).map(|k| phase(k as f64 * sample_s).sin()).collect()
            }
            Self::Steps { hold_s } => {
                let length = ((hold_s / sample_s).round() as usize).max(1);
                let mut level = 0.0;
                (0..count)
                    .map(|k| {
                        if k % length == 0 {
                            level = 2.0 * generator.random::<f64>() - 1.0;
                        }
                        level
                    })
                    .collect()
            }
        };
        let square: f64 = samples.iter().map(|u| u * u).sum::<f64>() / count.max(1) as f64;
        if square > 0.0 {
            samples.iter_mut().for_each(|u| *u /= square.sqrt());
        }
        samples
    }
}

fn multisine(
    count: usize,
    sample_s: f64,
    highest_hz: f64,
    odd: bool,
    generator: &mut ChaCha12Rng,
) -> Vec<f64> {
    let line_hz = 1.0 / (count as f64 * sample_s);
    let last = ((highest_hz / line_hz) as usize).min(count.saturating_sub(1) / 2).max(1);
    let mut lines: Vec<usize> = (1..=last).step_by(if odd { 2 } else { 1 }).collect();
    if odd && lines.len() >= 4 {
        let left_out: Vec<usize> =
            lines.chunks_exact(4).map(|four| four[generator.random_range(0..4)]).collect();
        lines.retain(|line| !left_out.contains(line));
    }
    let table: Vec<f64> =
        (0..count).map(|k| (std::f64::consts::TAU * k as f64 / count as f64).cos()).collect();
    let mut samples = vec![0.0; count];
    for line in lines {
        // A whole number of table steps as phase: of 16 384 steps, none is missed.
        let mut phase = generator.random_range(0..count);
        for sample in &mut samples {
            *sample += table[phase];
            phase = (phase + line) % count;
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::{Stream, stream};

    fn amplitude(samples: &[f64], line: usize) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, u) in samples.iter().enumerate() {
            let angle = std::f64::consts::TAU * (line * k) as f64 / samples.len() as f64;
            re += u * angle.cos();
            im += u * angle.sin();
        }
        (re * re + im * im).sqrt() * 2.0 / samples.len() as f64
    }

    #[test]
    fn an_odd_multisine_leaves_even_lines_and_one_odd_line_of_four_free() {
        let kind = Excitation::Multisine { highest_hz: 100.0, odd: true };
        let samples = kind.samples(1024, 1e-3, &mut stream(1, Stream::Device));
        let lines: Vec<f64> = (0..150).map(|line| amplitude(&samples, line)).collect();
        let excited: Vec<usize> = (0..150).filter(|line| lines[*line] > 1e-6).collect();
        // 51 odd lines to 102, a quarter of each whole four left out.
        assert_eq!(excited.len(), 51 - 12);
        assert!(excited.iter().all(|line| line % 2 == 1));
        let first = lines[excited[0]];
        assert!(excited.iter().all(|line| (lines[*line] / first - 1.0).abs() < 1e-9));
        let rms = (samples.iter().map(|u| u * u).sum::<f64>() / 1024.0).sqrt();
        assert!((rms - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_sweep_grows_faster_and_steps_hold() {
        let sweep = Excitation::Sweep { lowest_hz: 1.0, highest_hz: 50.0 };
        let samples = sweep.samples(10_000, 1e-3, &mut stream(1, Stream::Device));
        let crossings = |part: &[f64]| part.windows(2).filter(|u| u[0] * u[1] < 0.0).count();
        assert!(crossings(&samples[9000..]) > 80 && crossings(&samples[..1000]) < 15);
        let steps = Excitation::Steps { hold_s: 0.1 }.samples(1000, 1e-3, &mut stream(1, Stream::Device));
        assert_eq!(steps.windows(2).filter(|u| u[0] != u[1]).count(), 9);
    }
}
