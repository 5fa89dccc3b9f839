//! Random processes: what wanders slowly and forgets exponentially.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

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
}
