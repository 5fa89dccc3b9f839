//! Whether an observable holds anything but its own reading noise. A temperature is slow, or goes with what is
//! done: a thermometer whose readings are independent of one another and of the angle shows its noise alone, and
//! no explanation can be told from any other by it.

use numerics::{Basis, centred, dot};

use crate::base::legendre;
use crate::calibrate::log_tail;
use crate::thresholds::content::{BLOCKS, ORDER, SURE};

/// Whether the values (in the order of time) are no more than noise, as far as `scaled_angle` (−1 … 1) and the
/// order of the rows can tell.
pub fn is_noise_alone(values: &[f64], scaled_angle: &[f64]) -> bool {
    let n = values.len();
    let about = centred(values);
    let variance = dot(&about, &about) / (n.max(2) - 1) as f64;
    if variance <= 0.0 {
        return true;
    }
    let slow = BLOCKS.iter().filter(|count| **count * 4 <= n).any(|&count| {
        let between: f64 = (0..count)
            .map(|k| &about[k * n / count..(k + 1) * n / count])
            .map(|block| block.iter().sum::<f64>().powi(2) / block.len() as f64)
            .sum();
        log_tail(between / variance, count - 1) > SURE
    });
    let mut curve = Basis::new(n);
    for column in &legendre(scaled_angle, ORDER)[1..] {
        curve.add(&centred(column));
    }
    let along: f64 = (0..curve.rank()).map(|k| dot(curve.columns.get(k), &about).powi(2)).sum();
    !slow && log_tail(along / variance, curve.rank()) <= SURE
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::is_noise_alone;

    #[test]
    fn noise_is_noise_and_a_slow_change_below_it_is_not() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let n = 210;
        let angle: Vec<f64> = (0..n).map(|i| (f64::from(i) * 0.31).sin()).collect();
        for _ in 0..20 {
            let noise: Vec<f64> = (0..n).map(|_| random.random::<f64>() - 0.5).collect();
            assert!(is_noise_alone(&noise, &angle));
            // A drift of one and a half standard deviations over the recording, and one with the angle.
            let drift = noise.iter().enumerate().map(|(i, v)| v + 0.45 * i as f64 / f64::from(n));
            assert!(!is_noise_alone(&drift.collect::<Vec<f64>>(), &angle));
            let tied = noise.iter().zip(&angle).map(|(v, x)| v + 0.25 * x);
            assert!(!is_noise_alone(&tied.collect::<Vec<f64>>(), &angle));
        }
    }
}
