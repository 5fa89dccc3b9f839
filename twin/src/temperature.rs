//! The temperature of the base plate over one recording.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::environment::LABORATORY_C;
use crate::noise::Wander;

/// What the temperature does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Temperature {
    /// The paper's laboratory: 27 ± 1 °C, cycling slowly.
    Laboratory,
    /// It runs evenly from one temperature to another over the recording: with time, and cannot be told
    /// from it.
    Ramp {
        /// Temperature at the start in °C.
        from_c: f64,
        /// Temperature at the end in °C.
        to_c: f64,
    },
    /// A climatic chamber that cycles about a mean, evenly about the middle of the recording, so that the
    /// temperature is independent of time; between one and two and a half cycles.
    Chamber {
        /// Mean temperature in °C.
        mean_c: f64,
        /// Amplitude of the cycles in kelvins.
        amplitude_k: f64,
    },
    /// A climatic chamber that holds levels for equal times, and reaches each exponentially.
    Levels {
        /// The levels in °C, at least one.
        levels_c: Vec<f64>,
        /// The time constant of the chamber in seconds.
        time_constant_s: f64,
    },
}

impl Temperature {
    /// Up by six kelvins in one recording.
    pub fn ramp() -> Self {
        Self::Ramp { from_c: 24.0, to_c: 30.0 }
    }

    /// About 27.5 °C by 13 K either way.
    pub fn chamber() -> Self {
        Self::Chamber { mean_c: 27.5, amplitude_k: 13.0 }
    }

    /// Three levels, both ways.
    pub fn levels() -> Self {
        Self::Levels { levels_c: vec![15.0, 27.5, 40.0, 27.5, 15.0], time_constant_s: 60.0 }
    }
}

/// The course of the temperature over one recording.
pub(crate) struct Course {
    /// In °C, of the time in seconds and of what the air adds, in kelvins.
    of: Box<dyn FnMut(f64, f64) -> f64>,
    air: Wander,
}

impl Course {
    pub(crate) fn start(kind: &Temperature, duration_s: f64, generator: &mut impl Rng) -> Self {
        let duration_s = duration_s.max(1.0);
        let (deviation_k, of): (f64, Box<dyn FnMut(f64, f64) -> f64>) = match *kind {
            Temperature::Laboratory => {
                // The air conditioning cycles in a quarter of an hour to three quarters.
                let cycle_k = generator.random_range(0.3..0.55);
                let cycle_s = generator.random_range(900.0..2700.0);
                let phase = generator.random_range(0.0..TAU);
                // The control never lets the temperature leave ±1 K.
                let of = move |t_s: f64, air_k: f64| {
                    LABORATORY_C + (cycle_k * (TAU * t_s / cycle_s + phase).sin() + air_k).clamp(-1.0, 1.0)
                };
                (0.12, Box::new(of))
            }
            Temperature::Ramp { from_c, to_c } => {
                let per_s = (to_c - from_c) / duration_s;
                (0.03, Box::new(move |t_s, air_k| from_c + per_s * t_s + air_k))
            }
            Temperature::Chamber { mean_c, amplitude_k } => {
                let upward = if generator.random_bool(0.5) { 1.0 } else { -1.0 };
                let amplitude_k = upward * amplitude_k;
                let per_s = TAU * generator.random_range(1.0..2.5) / duration_s;
                let middle_s = 0.5 * duration_s;
                let of = move |t_s: f64, air_k: f64| {
                    mean_c + amplitude_k * (per_s * (t_s - middle_s)).cos() + air_k
                };
                (0.1, Box::new(of))
            }
            Temperature::Levels { ref levels_c, time_constant_s } => {
                (0.1, Box::new(levels(levels_c.clone(), time_constant_s, duration_s)))
            }
        };
        Self { of, air: Wander::start(deviation_k, 400.0, generator) }
    }

    /// The temperature in °C at `t_s`, which must not lie before the last time asked for.
    pub(crate) fn at(&mut self, t_s: f64, generator: &mut impl Rng) -> f64 {
        let air_k = self.air.at(t_s, generator);
        (self.of)(t_s, air_k)
    }
}

/// A chamber that comes exponentially to each level in turn.
fn levels(levels_c: Vec<f64>, time_constant_s: f64, duration_s: f64) -> impl FnMut(f64, f64) -> f64 {
    let hold_s = duration_s / levels_c.len().max(1) as f64;
    let mut now_c = levels_c.first().copied().unwrap_or(LABORATORY_C);
    let mut last_s = 0.0;
    move |t_s, air_k| {
        while last_s < t_s {
            // Up to the reading or the next change of level, whichever comes first.
            let index = ((last_s / hold_s) as usize).min(levels_c.len().saturating_sub(1));
            let change_s = (index + 1) as f64 * hold_s;
            let to_s = if change_s > last_s { t_s.min(change_s) } else { t_s };
            let level = levels_c.get(index).copied().unwrap_or(LABORATORY_C);
            now_c = level + (now_c - level) * (-(to_s - last_s) / time_constant_s).exp();
            last_s = to_s;
        }
        now_c + air_k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::{Stream, stream};

    fn course(kind: &Temperature, seed: u64) -> Vec<f64> {
        let mut generator = stream(seed, Stream::Environment);
        let mut course = Course::start(kind, 1000.0, &mut generator);
        (1..=1000).map(|t| course.at(f64::from(t), &mut generator)).collect()
    }

    /// The correlation with time.
    fn with_time(values: &[f64]) -> f64 {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let (mut cross, mut square, mut time) = (0.0, 0.0, 0.0);
        for (i, v) in values.iter().enumerate() {
            let t = i as f64 - 0.5 * (n - 1.0);
            cross += t * (v - mean);
            square += (v - mean).powi(2);
            time += t * t;
        }
        cross / (square * time).sqrt()
    }

    #[test]
    fn the_chamber_is_independent_of_time_and_the_ramp_is_time() {
        for seed in 0..20 {
            assert!(with_time(&course(&Temperature::chamber(), seed)).abs() < 0.05);
            assert!(with_time(&course(&Temperature::ramp(), seed)) > 0.99);
            // Levels both ways, apart from the delay of the chamber.
            assert!(with_time(&course(&Temperature::levels(), seed)).abs() < 0.3);
        }
    }

    #[test]
    fn levels_are_reached_and_the_laboratory_is_held() {
        let levels = course(&Temperature::levels(), 1);
        for (t, level) in [(198, 15.0), (398, 27.5), (598, 40.0), (798, 27.5), (998, 15.0)] {
            // 200 s are more than three time constants of a change of 12.5 K.
            assert!((levels[t] - level).abs() < 1.0, "{} at {t}", levels[t]);
        }
        for seed in 0..20 {
            assert!(course(&Temperature::Laboratory, seed).iter().all(|t| (26.0..=28.0).contains(t)));
        }
    }
}
