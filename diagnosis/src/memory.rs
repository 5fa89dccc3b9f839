//! What it costs an amplitude that the memory of the noise is itself an estimate. The amplitude is estimated with
//! one correlation time, and scatters as it does with the true one: a slow effect in noise correlated over longer
//! than was thought is known far less well. Averaged over the posterior of the correlation time, with the level
//! that goes with each.

use numerics::dot;

use crate::noise::Noise;

/// Ratio of an amplitude's standard deviation, the correlation time drawn from its posterior, to that at the
/// estimate. `direction` is the whitened direction that the amplitude is read off; `residual` what the
/// model leaves of the whitened observations. Never below 1.
pub fn spread(noise: &Noise, direction: &[f64], residual: &[f64]) -> f64 {
    let [length, level] = [direction, residual].map(|v| dot(v, v));
    if !(length > 0.0 && level > 0.0) {
        return 1.0;
    }
    let here = &noise.correlation;
    // The amplitude is direction · W ε: in terms of the noise, Wᵀ direction.
    let weights = here.whiten_transposed(direction);
    let coloured = here.colour(residual.iter().copied());
    let variance: f64 = noise
        .posterior
        .iter()
        .map(|(process, weight)| {
            let there = here.with(process);
            let drawn = there.colour_transposed(&weights);
            let white = there.whiten(coloured.iter().copied());
            weight * dot(&drawn, &drawn) / length * dot(&white, &white) / level
        })
        .sum();
    variance.max(1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::spread;
    use crate::correlation::{Correlation, Process};
    use crate::noise::estimate;
    use numerics::dot;

    #[test]
    fn transposes_are_transposes() {
        let n = 40;
        let process = Process { new: 0.3, parts: vec![(0.4, 3.0), (0.3, 50.0)] };
        let correlation = Correlation::none(&(0..n).map(f64::from).collect::<Vec<f64>>()).with(&process);
        let column =
            |k: i32| (0..n).map(|i| f64::from((i * i * k + 7 * i) % 23) - 11.0).collect::<Vec<f64>>();
        let (a, b) = (column(3), column(5));
        let white = correlation.whiten(b.iter().copied());
        assert!((dot(&a, &white) - dot(&correlation.whiten_transposed(&a), &b)).abs() < 1e-9);
        let coloured = correlation.colour(b.iter().copied());
        assert!((dot(&a, &coloured) - dot(&correlation.colour_transposed(&a), &b)).abs() < 1e-9);
    }

    #[test]
    fn an_unknown_memory_widens_what_is_slow_and_not_what_is_fast() {
        let n = 120;
        let t: Vec<f64> = (0..n).map(f64::from).collect();
        let y: Vec<f64> = (0..n).map(|i| f64::from((i * 7919) % 101) / 50.5 - 1.0).collect();
        let mut noise = estimate(&y, &t, &[vec![1.0; 120]], &[], &[], &[]);
        noise.correlation = noise.correlation.with(&Process::white());
        noise.posterior = vec![(Process::white(), 0.5), (Process::slow(1.0, 2.0), 0.5)];
        let alternating: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        // A residual that itself has the longer memory half way, so that both levels are alike.
        let residual = noise.correlation.with(&Process::slow(1.0, 1.0)).colour(y.iter().copied());
        assert!(spread(&noise, &vec![1.0; 120], &residual) > 1.2);
        assert!(spread(&noise, &alternating, &residual) < 1.05);
    }
}
