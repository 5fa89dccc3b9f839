//! Noise: its families, random processes that wander and forget, and the true covariance of the readings.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha12Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

/// The kind of noise that probes and autocollimator have. Its size is that of the device.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Noise {
    /// Normal, every reading for itself.
    White,
    /// Normal, and alike in readings that follow soon: the correlation falls as e^(−|Δt|/τ).
    Autocorrelated {
        /// τ in seconds.
        correlation_time_s: f64,
    },
    /// Normal, and larger towards the ends of the stroke, in proportion to 1 + (e − 1)·(θ/θ_end)², with the
    /// same mean square as the white one.
    Heteroscedastic {
        /// e, the standard deviation at the ends over that in the centre.
        edge_over_centre: f64,
    },
    /// Normal, but for some readings whose reference is disturbed much more.
    Outliers {
        /// The share of such readings.
        share: f64,
        /// How many times the autocollimator's noise they have.
        factor: f64,
    },
    /// White noise and 1/f noise of the same size, over four decades of time.
    Flicker,
    /// White noise, and a walk that grows by as much within 300 s.
    RandomWalk,
    /// White noise, and a level that jumps between two values every 150 s on average.
    Popcorn,
    /// White noise that is six times as large for 10 s, every 150 s on average.
    Bursts,
}

impl Noise {
    /// τ = 7 s: readings that follow after 3 s correlate by 0.65.
    pub fn autocorrelated() -> Self {
        Self::Autocorrelated { correlation_time_s: 7.0 }
    }

    /// Four times as large at the ends as in the centre.
    pub fn heteroscedastic() -> Self {
        Self::Heteroscedastic { edge_over_centre: 4.0 }
    }

    /// Two in a hundred, of eight times the noise.
    pub fn outliers() -> Self {
        Self::Outliers { share: 0.02, factor: 8.0 }
    }

    /// The factor on every standard deviation at a place in the stroke, from −1 to 1.
    pub fn factor_at(&self, place: f64) -> f64 {
        match *self {
            Self::Heteroscedastic { edge_over_centre } => {
                let growth = edge_over_centre - 1.0;
                // Mean square of 1 + g x² over the stroke: 1 + 2g/3 + g²/5.
                let mean_square = 1.0 + growth * (2.0 / 3.0 + growth / 5.0);
                (1.0 + growth * place * place) / mean_square.sqrt()
            }
            _ => 1.0,
        }
    }

    /// The factor on the variance of the autocollimator that outliers make on average.
    pub fn outlier_variance(&self) -> f64 {
        match *self {
            Self::Outliers { share, factor } => 1.0 + share * (factor * factor - 1.0),
            _ => 1.0,
        }
    }

    /// By how much the autocollimator's noise is larger in the next reading: 1, but for an outlier.
    pub(crate) fn disturbance(&self, generator: &mut impl Rng) -> f64 {
        match *self {
            Self::Outliers { share, factor } if generator.random_bool(share.clamp(0.0, 1.0)) => factor,
            _ => 1.0,
        }
    }

    /// The correlation of the noise of two readings that lie so far apart in time; of noise that lasts, its white part
    /// alone.
    pub fn correlation(&self, apart_s: f64) -> f64 {
        match *self {
            Self::Autocorrelated { correlation_time_s } => (-apart_s.abs() / correlation_time_s).exp(),
            _ if apart_s == 0.0 => 1.0,
            _ => 0.0,
        }
    }
}

/// A source of noise of unit standard deviation for several instruments.
#[derive(Debug)]
pub(crate) struct Source {
    generator: ChaCha12Rng,
    wanders: Vec<Wander>,
    lasting: Vec<Lasting>,
}

impl Source {
    pub(crate) fn start(noise: &Noise, instruments: usize, mut generator: ChaCha12Rng) -> Self {
        let wanders = match *noise {
            Noise::Autocorrelated { correlation_time_s } => {
                (0..instruments).map(|_| Wander::start(1.0, correlation_time_s, &mut generator)).collect()
            }
            _ => Vec::new(),
        };
        let lasting = (0..instruments).filter_map(|_| Lasting::start(noise, &mut generator)).collect();
        Self { generator, wanders, lasting }
    }

    /// The noise of one instrument in the reading at `t_s`.
    pub(crate) fn draw(&mut self, instrument: usize, t_s: f64) -> f64 {
        let generator = &mut self.generator;
        match (self.wanders.get_mut(instrument), self.lasting.get_mut(instrument)) {
            (Some(wander), _) => wander.at(t_s, generator),
            (None, Some(lasting)) => lasting.at(t_s, generator),
            (None, None) => generator.sample(StandardNormal),
        }
    }
}

/// White noise, and what lasts beside it.
#[derive(Debug)]
struct Lasting {
    kind: Process,
    time_s: f64,
}

#[derive(Debug)]
enum Process {
    /// 1/f: processes whose correlation times are a factor √10 apart, each of the same size.
    Flicker(Vec<Wander>),
    Walk(f64),
    /// The level, and when it changes next.
    Popcorn(f64, f64),
    /// Whether it is loud, and when that changes next.
    Bursts(bool, f64),
}

impl Lasting {
    fn start(noise: &Noise, generator: &mut impl Rng) -> Option<Self> {
        let kind = match noise {
            Noise::Flicker => {
                let size = 1.0 / 9f64.sqrt();
                let time_s = |half_decade: i32| 10f64.powf(0.5 * f64::from(half_decade));
                Process::Flicker((0..9).map(|k| Wander::start(size, time_s(k), generator)).collect())
            }
            Noise::RandomWalk => Process::Walk(0.0),
            Noise::Popcorn => Process::Popcorn(1.0, waiting_s(150.0, generator)),
            Noise::Bursts => Process::Bursts(false, waiting_s(150.0, generator)),
            _ => return None,
        };
        Some(Self { kind, time_s: 0.0 })
    }

    /// The noise of the reading at `time_s`, which must not lie before the last one asked for.
    fn at(&mut self, time_s: f64, generator: &mut impl Rng) -> f64 {
        let step_s = time_s - self.time_s;
        self.time_s = time_s;
        let white: f64 = generator.sample(StandardNormal);
        match &mut self.kind {
            Process::Flicker(wanders) => {
                white + wanders.iter_mut().map(|wander| wander.at(time_s, generator)).sum::<f64>()
            }
            Process::Walk(level) => {
                *level += (step_s / 300.0).sqrt() * generator.sample::<f64, _>(StandardNormal);
                white + *level
            }
            Process::Popcorn(level, next_s) => {
                while *next_s < time_s {
                    *level = -*level;
                    *next_s += waiting_s(150.0, generator);
                }
                white + *level
            }
            Process::Bursts(loud, next_s) => {
                while *next_s < time_s {
                    *loud = !*loud;
                    *next_s += waiting_s(if *loud { 10.0 } else { 150.0 }, generator);
                }
                white * if *loud { 6.0 } else { 1.0 }
            }
        }
    }
}

/// The time until something happens that happens at random, in `mean_s` on average.
fn waiting_s(mean_s: f64, generator: &mut impl Rng) -> f64 {
    -mean_s * (1.0 - generator.random::<f64>()).ln()
}

/// A stationary Ornstein–Uhlenbeck process, advanced exactly over steps of any length.
#[derive(Debug, Clone, PartialEq)]
pub struct Wander {
    deviation: f64,
    correlation_time_s: f64,
    value: f64,
    time_s: f64,
}

impl Wander {
    /// Starts in the steady state at time 0; `deviation` is the standard deviation, in the unit of the
    /// value.
    pub fn start(deviation: f64, correlation_time_s: f64, generator: &mut impl Rng) -> Self {
        let value = deviation * generator.sample::<f64, _>(StandardNormal);
        Self { deviation, correlation_time_s, value, time_s: 0.0 }
    }

    /// The value at `time_s`, which must not lie before the last one asked for.
    pub fn at(&mut self, time_s: f64, generator: &mut impl Rng) -> f64 {
        let kept = (-(time_s - self.time_s) / self.correlation_time_s).exp();
        let fresh = self.deviation * (1.0 - kept * kept).sqrt();
        self.value = kept * self.value + fresh * generator.sample::<f64, _>(StandardNormal);
        self.time_s = time_s;
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streams::{Stream, stream};

    #[test]
    fn wander_has_its_deviation_and_correlation() {
        let mut generator = stream(3, Stream::Environment);
        let (mut square, mut product) = (0.0, 0.0);
        let runs = 20_000;
        for _ in 0..runs {
            let mut wander = Wander::start(2.0, 100.0, &mut generator);
            let first = wander.at(5.0, &mut generator);
            let second = wander.at(105.0, &mut generator);
            square += second * second / f64::from(runs);
            product += first * second / f64::from(runs);
        }
        // Five standard errors of a variance of 4 from 20 000 values.
        approx::assert_abs_diff_eq!(square, 4.0, epsilon = 0.2);
        approx::assert_abs_diff_eq!(product, 4.0 * (-1f64).exp(), epsilon = 0.2);
    }

    #[test]
    fn growing_noise_has_the_mean_square_of_the_white_one() {
        let noise = Noise::heteroscedastic();
        let count = 20_000;
        let place = |i: i32| (2.0 * f64::from(i) + 1.0) / f64::from(count) - 1.0;
        let mean: f64 = (0..count).map(|i| noise.factor_at(place(i)).powi(2)).sum::<f64>() / f64::from(count);
        approx::assert_abs_diff_eq!(mean, 1.0, epsilon = 1e-6);
        approx::assert_abs_diff_eq!(noise.factor_at(1.0) / noise.factor_at(0.0), 4.0, epsilon = 1e-12);
    }
}
