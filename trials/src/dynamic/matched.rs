//! The strength of what an effect adds to a recorded position: its signal to noise after whitening, and after
//! taking off what something else could take up.

use twin::Noise;
use twin::dynamic::Bench;

use crate::linear::norm;

/// Whitens by the true noise.
#[derive(Debug, Clone, Copy)]
pub struct Whitener {
    deviation: f64,
    /// Correlation of two samples that follow.
    follows: f64,
    /// After so many rows a run begins anew.
    run: usize,
}

impl Whitener {
    /// The whitener of a bench's noise.
    pub fn of(bench: &Bench) -> Self {
        let follows = match bench.noise {
            Noise::Autocorrelated { .. } => bench.noise.correlation(bench.sample_s),
            _ => 0.0,
        };
        let run = bench.samples * bench.periods.unwrap_or(1) as usize;
        Self { deviation: bench.noise_arcsec, follows, run }
    }

    /// The values such that noise in them is white and has the deviation 1.
    pub fn whiten(&self, values: &[f64]) -> Vec<f64> {
        let fresh = self.deviation * (1.0 - self.follows * self.follows).sqrt();
        let first = |row: usize| row.is_multiple_of(self.run);
        (0..values.len())
            .map(|row| match first(row) {
                true => values[row] / self.deviation,
                false => (values[row] - self.follows * values[row - 1]) / fresh,
            })
            .collect()
    }
}

/// Root mean square.
pub fn rms(values: &[f64]) -> f64 {
    norm(values) / (values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitened_noise_is_white_and_a_constant_has_its_strength() {
        let noise = Noise::Autocorrelated { correlation_time_s: 2e-3 };
        let bench = Bench { noise, samples: 4096, ..Bench::from_seed(1) };
        let (noisy, clean) = (bench.record(4).unwrap(), bench.record_noiseless(4).unwrap());
        let added: Vec<f64> =
            noisy.positions[0].iter().zip(&clean.positions[0]).map(|(a, b)| a - b).collect();
        let white = Whitener::of(&bench).whiten(&added);
        // Five standard errors.
        assert!((rms(&white) - 1.0).abs() < 5.0 / 8192f64.sqrt(), "{}", rms(&white));
        let follows: f64 = white.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 4096.0;
        assert!(follows.abs() < 5.0 / 64.0, "{follows}");
        let plain = Bench { noise: Noise::White, ..bench };
        assert!((norm(&Whitener::of(&plain).whiten(&[0.9; 100])) - 10.0).abs() < 1e-9);
    }
}
