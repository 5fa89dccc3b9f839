//! How the noise of readings that follow one another correlates: as e^(−Δt/τ), in time and not from row to row, because a
//! recording may be read fast in one pass, slowly in the next, and pause between them. Whether noise that lasts would do as
//! well as an effect is asked with more processes ([`Process`], [`Correlation::gain`]).
//!
//! τ is estimated by restricted maximum likelihood, which allows for the columns that are fitted, and keeps
//! its whole posterior: a test that took the estimate for the truth would raise false alarms. What looks like
//! slow noise and is none is taken out first ([`Correlation::mistaken`]).

mod filter;
mod mistaken;
mod process;

pub use filter::{Correlation, Whitener};
pub use mistaken::suspect;
pub use process::Process;

use numerics::{Basis, Columns, cholesky, parallel, quadratic_form};

use crate::thresholds::correlation::{COARSE, HOPELESS, NEGLIGIBLE, PRIOR_UNCORRELATED};

impl Correlation {
    /// Posterior of a process of one time constant given `clean` observations about the span of `model`, each row of standard deviation
    /// proportional to `shape`: processes with weights that sum to one, the soonest forgotten first.
    pub fn posterior(&self, clean: &[f64], model: &[Vec<f64>], shape: &[f64]) -> Vec<(Process, f64)> {
        let columns = orthonormal(model, shape);
        let observed: Vec<f64> = clean.iter().zip(shape).map(|(v, s)| v / s).collect();
        let at_white = restricted(&columns, &observed, &self.with(&Process::white()));
        let processes = self.forgotten();
        let at = |process: &Process| restricted(&columns, &observed, &self.with(process)) - at_white;
        let coarse = |k: usize| k.is_multiple_of(COARSE).then(|| at(&processes[k]));
        let likelihood: Vec<Option<f64>> = parallel::indices(0..processes.len(), coarse);
        let best = likelihood.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
        let hopeful: Vec<bool> =
            likelihood.iter().map(|l| l.is_some_and(|l| l > best - HOPELESS && l > -HOPELESS)).collect();
        let likelihood = parallel::indices(0..processes.len(), |k| {
            let (before, after) = (k / COARSE * COARSE, (k / COARSE + 1) * COARSE);
            let between = hopeful[before] || hopeful.get(after) == Some(&true);
            likelihood[k].or_else(|| between.then(|| at(&processes[k])))
        });
        // Relative to the likeliest: read fast, a recording of some hundred rows tells by a factor beyond any number.
        let likeliest = best.max(0.0);
        let each = (1.0 - PRIOR_UNCORRELATED) / processes.len() as f64;
        let weights = likelihood.iter().map(|l| each * l.map_or(0.0, |l| (l - likeliest).exp()));
        let mut posterior = vec![(Process::white(), PRIOR_UNCORRELATED * (-likeliest).exp())];
        posterior.extend(processes.iter().cloned().zip(weights));
        let sum = |posterior: &[(Process, f64)]| posterior.iter().map(|(_, w)| w).sum::<f64>();
        let total = sum(&posterior);
        posterior.retain(|(_, w)| *w > NEGLIGIBLE * total);
        let total = sum(&posterior);
        posterior.iter_mut().for_each(|(_, w)| *w /= total);
        posterior
    }
}

/// An orthonormal basis of the model's columns, each divided by `shape`: what depends on the others is left
/// out once and for all, so that every correlation is judged on the same columns.
fn orthonormal(model: &[Vec<f64>], shape: &[f64]) -> Columns {
    let mut basis = Basis::new(shape.len());
    for column in model {
        basis.add(&column.iter().zip(shape).map(|(v, s)| v / s).collect::<Vec<f64>>());
    }
    basis.columns
}

/// Restricted log likelihood of a correlation: that of the observations' part outside the columns.
fn restricted(columns: &Columns, observed: &[f64], correlation: &Correlation) -> f64 {
    let n = columns.rows;
    let mut white = correlation.whitened(columns);
    white.push(&correlation.whiten(observed.iter().copied()));
    let p = columns.count();
    let m = p + 1;
    let gram = white.products(&white);
    let xx: Vec<f64> = (0..p * p).map(|i| gram[(i % p) * m + i / p]).collect();
    let xy: Vec<f64> = (0..p).map(|k| gram[p * m + k]).collect();
    let (factor, log_determinant) = cholesky(&xx, p);
    let left = (gram[p * m + p] - quadratic_form(&factor, &xy)).max(1e-300);
    -0.5 * (correlation.log_determinant() + log_determinant + (n - p) as f64 * left.ln())
}

#[cfg(test)]
pub(crate) mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{Correlation, Process};

    /// Normal deviates by the sum of twelve uniform ones.
    pub fn white(n: usize, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..n).map(|_| (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0).collect()
    }

    /// Twelve passes of seventy rows, read every 0.5, 0.2 or 0.1 s, with pauses of 30 s.
    fn times() -> Vec<f64> {
        let mut t = 0.0;
        (0..840)
            .map(|i| {
                t += if i % 70 == 0 { 30.0 } else { [0.5, 0.2, 0.1][i / 70 % 3] };
                t
            })
            .collect()
    }

    #[test]
    fn whitening_undoes_colouring() {
        let correlation =
            Correlation::none(&times()).with(&Process { new: 0.2, parts: vec![(0.5, 20.0), (0.3, 300.0)] });
        let drawn = white(840, 1);
        let again = correlation.whiten(correlation.colour(drawn.iter().copied()).into_iter());
        // The factors come within 5e-3 of 1: rounding grows by their inverse.
        assert!(drawn.iter().zip(again).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn correlation_is_in_time_whatever_the_pace() {
        // 0.2 s is the typical gap, so that τ = 7 s is 35 of them.
        let none = Correlation::none(&times());
        let model = vec![vec![1.0; 840]];
        let shape = vec![1.0; 840];
        for seed in 2..6 {
            let clean = none.with(&Process::slow(1.0, 35.0)).colour(white(840, seed).into_iter());
            let posterior = none.posterior(&clean, &model, &shape);
            let found = -1.0 / Process::mean(&posterior).after(1.0).ln();
            // Some sixty independent stretches determine τ to about a quarter: two and a half of those.
            assert!((0.5 * 35.0..2.2 * 35.0).contains(&found), "{found}");
            let uncorrelated = none.posterior(&white(840, seed), &model, &shape);
            assert!(Process::mean(&uncorrelated).after(1.0) < 0.15);
        }
    }

    #[test]
    fn many_rows_leave_no_doubt_however_likely() {
        let n = 2400;
        let none = Correlation::none(&(0..n).map(|i| 0.05 * i as f64).collect::<Vec<f64>>());
        let clean = none.with(&Process::slow(1.0, 40.0)).colour(white(n, 7).into_iter());
        let posterior = none.posterior(&clean, &[vec![1.0; n]], &vec![1.0; n]);
        // Sixty stretches of the memory's length: the time constant is known to a third.
        let near: f64 = posterior
            .iter()
            .filter(|(p, _)| (20.0..80.0).contains(&p.parts.first().map_or(0.0, |(_, time)| *time)))
            .map(|(_, w)| w)
            .sum();
        assert!(near > 0.9, "{posterior:?}");
    }

    #[test]
    fn what_a_wandering_reference_does_as_well_gains_nothing() {
        let n = 400;
        let none = Correlation::none(&(0..n).map(|i| 2.0 * i as f64).collect::<Vec<f64>>());
        let (model, shape) = (vec![vec![1.0; n]], vec![1.0; n]);
        let slow = vec![(0..n).map(|i| (i as f64 / 60.0).sin()).collect::<Vec<f64>>()];
        for seed in 11..15 {
            // Half of the variance is forgotten at once, so that neighbours tell little of what lasts.
            let wanders = none.with(&Process::slow(0.5, 60.0)).colour(white(n, seed).into_iter());
            assert!(none.gain(&wanders, &model, &shape, &slow) < 12.0);
            let moved: Vec<f64> = white(n, seed).iter().zip(&slow[0]).map(|(e, s)| e + s).collect();
            assert!(none.gain(&moved, &model, &shape, &slow) > 18.0);
        }
    }
}
