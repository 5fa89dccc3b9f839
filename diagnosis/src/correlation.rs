//! How the noise of readings that follow one another correlates: as e^(−Δt/τ), in time and not from row to
//! row, because a recording may be read fast in one pass, slowly in the next, and pause between them.
//!
//! τ is estimated by restricted maximum likelihood, which allows for the columns that are fitted, and keeps
//! its whole posterior: a test that took the estimate for the truth would raise false alarms. What looks like
//! slow noise and is none is taken out first ([`Correlation::mistaken`]).

mod mistaken;

pub use mistaken::suspect;

use rayon::prelude::*;

use crate::numerics::median;
use crate::numerics::{Basis, Columns, cholesky, quadratic_form};
use crate::thresholds::correlation::{COARSE, HOPELESS, POINTS, PRIOR_UNCORRELATED, SHORTEST};

/// Correlation of every row with the one before, e^(−Δt/τ).
#[derive(Debug, Clone)]
pub struct Correlation {
    /// Time since the previous row in typical gaps; the first row has none.
    gaps: Vec<f64>,
    /// φ = e^(−Δt/τ) of every row; 0 for the first.
    factors: Vec<f64>,
    /// √(1 − φ²) of every row.
    fresh: Vec<f64>,
    /// τ in typical gaps; 0 for uncorrelated readings.
    pub time: f64,
}

impl Correlation {
    /// Uncorrelated readings at these times (seconds, not decreasing).
    pub fn none(t_s: &[f64]) -> Correlation {
        let mut steps: Vec<f64> = t_s.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
        let typical = median(&mut steps).max(1e-12);
        let gap = |w: &[f64]| ((w[1] - w[0]) / typical).max(1e-3);
        let gaps: Vec<f64> = std::iter::once(f64::INFINITY).chain(t_s.windows(2).map(gap)).collect();
        Correlation { gaps, factors: vec![0.0; t_s.len()], fresh: vec![1.0; t_s.len()], time: 0.0 }
    }

    /// The same readings with the correlation time `time` (typical gaps).
    pub fn with(&self, time: f64) -> Correlation {
        let factor = |g: &f64| if time > 0.0 { (-g / time).exp() } else { 0.0 };
        let factors: Vec<f64> = self.gaps.iter().map(factor).collect();
        let fresh = factors.iter().map(|phi| (1.0 - phi * phi).sqrt()).collect();
        Correlation { gaps: self.gaps.clone(), factors, fresh, time }
    }

    /// Correlation of readings one typical gap apart.
    pub fn typical(&self) -> f64 {
        if self.time > 0.0 { (-1.0 / self.time).exp() } else { 0.0 }
    }

    /// Makes values of this correlation white, of the same variance.
    pub fn whiten(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let values: Vec<f64> = values.collect();
        if self.time == 0.0 {
            return values;
        }
        let mut out = values.clone();
        let earlier = values.iter().zip(&self.factors[1..]).zip(&self.fresh[1..]);
        for (later, ((v, phi), fresh)) in out[1..].iter_mut().zip(earlier) {
            *later = (*later - phi * v) / fresh;
        }
        out
    }

    /// What makes values white whose rows have these standard deviations.
    pub fn whitener(&self, sigma: &[f64]) -> Whitener {
        let own: Vec<f64> = sigma.iter().zip(&self.fresh).map(|(s, fresh)| 1.0 / (s * fresh)).collect();
        let earlier = match self.time > 0.0 {
            true => (1..sigma.len()).map(|i| self.factors[i] / (sigma[i - 1] * self.fresh[i])).collect(),
            false => Vec::new(),
        };
        Whitener { own, earlier }
    }

    /// Gives white values this correlation: the inverse of [`Correlation::whiten`].
    pub fn colour(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut previous = 0.0;
        values
            .zip(self.factors.iter().zip(&self.fresh))
            .map(|(w, (phi, fresh))| {
                previous = phi * previous + fresh * w;
                previous
            })
            .collect()
    }

    /// The transpose of [`Correlation::whiten`].
    pub fn whiten_transposed(&self, values: &[f64]) -> Vec<f64> {
        let own = |i: usize| values[i] / (1.0 - self.factors[i].powi(2)).sqrt();
        let next = |i: usize| self.factors.get(i).map_or(0.0, |phi| phi * own(i));
        (0..values.len()).map(|i| own(i) - next(i + 1)).collect()
    }

    /// The transpose of [`Correlation::colour`].
    pub fn colour_transposed(&self, values: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; values.len()];
        let mut later = 0.0;
        for i in (0..values.len()).rev() {
            later = values[i] + self.factors.get(i + 1).map_or(0.0, |phi| phi * later);
            out[i] = (1.0 - self.factors[i].powi(2)).sqrt() * later;
        }
        out
    }

    /// ln det of the correlation matrix.
    fn log_determinant(&self) -> f64 {
        2.0 * self.fresh.iter().map(|f| f.ln()).sum::<f64>()
    }

    /// The grid of correlation times, ascending, without 0.
    fn grid(&self) -> Vec<f64> {
        let duration: f64 = self.gaps[1..].iter().sum();
        let longest = (0.25 * duration).max(4.0 * SHORTEST);
        let part = |k: usize| k as f64 / (POINTS - 1) as f64;
        (0..POINTS).map(|k| SHORTEST * (longest / SHORTEST).powf(part(k))).collect()
    }

    /// Posterior of τ (typical gaps; 0: uncorrelated) as values with weights that sum to one, given `clean`
    /// observations about the span of `model`, each row of standard deviation proportional to `shape`.
    pub fn posterior(&self, clean: &[f64], model: &[Vec<f64>], shape: &[f64]) -> Vec<(f64, f64)> {
        let columns = orthonormal(model, shape);
        let observed: Vec<f64> = clean.iter().zip(shape).map(|(v, s)| v / s).collect();
        let at_zero = restricted(&columns, &observed, &self.with(0.0));
        let grid = self.grid();
        let at = |k: usize| restricted(&columns, &observed, &self.with(grid[k])) - at_zero;
        let mut likelihood: Vec<Option<f64>> =
            (0..POINTS).into_par_iter().map(|k| k.is_multiple_of(COARSE).then(|| at(k))).collect();
        let best = likelihood.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
        let hopeful: Vec<bool> =
            likelihood.iter().map(|l| l.is_some_and(|l| l > best - HOPELESS && l > -HOPELESS)).collect();
        likelihood.par_iter_mut().enumerate().filter(|(_, v)| v.is_none()).for_each(|(k, value)| {
            let (before, after) = (k / COARSE * COARSE, (k / COARSE + 1) * COARSE);
            if hopeful[before] || hopeful.get(after) == Some(&true) {
                *value = Some(at(k));
            }
        });
        // Relative to the likeliest: read fast, a recording of some hundred rows tells by a factor beyond any number.
        let likeliest = best.max(0.0);
        let weights: Vec<f64> = likelihood.iter().map(|l| l.map_or(0.0, |l| (l - likeliest).exp())).collect();
        let slab = weights.iter().sum::<f64>() / POINTS as f64;
        let uncorrelated = PRIOR_UNCORRELATED * (-likeliest).exp();
        let total = uncorrelated + (1.0 - PRIOR_UNCORRELATED) * slab;
        let mut posterior = vec![(0.0, uncorrelated / total)];
        let each = (1.0 - PRIOR_UNCORRELATED) / (total * POINTS as f64);
        posterior.extend(grid.iter().zip(&weights).map(|(time, w)| (*time, w * each)));
        posterior.retain(|(_, w)| *w > 1e-5);
        let sum: f64 = posterior.iter().map(|(_, w)| w).sum();
        posterior.iter_mut().for_each(|(_, w)| *w /= sum);
        posterior
    }

    /// The correlation time whose typical correlation is the posterior's mean.
    pub fn mean(&self, posterior: &[(f64, f64)]) -> Correlation {
        let typical: f64 =
            posterior.iter().filter(|(t, _)| *t > 0.0).map(|(t, w)| w * (-1.0 / t).exp()).sum();
        self.with(if typical > 1e-4 { -1.0 / typical.ln() } else { 0.0 })
    }
}

/// Makes noise white, of variance one: each row divided by its σ, less what it has of its predecessor.
#[derive(Debug, Clone)]
pub struct Whitener {
    /// Weight of every row.
    own: Vec<f64>,
    /// Weight of the row before, from the second row on; empty where rows are uncorrelated.
    earlier: Vec<f64>,
}

impl Whitener {
    /// Makes `v` white.
    pub fn whiten(&self, v: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = v.iter().zip(&self.own).map(|(x, a)| x * a).collect();
        if let Some((_, later)) = out.split_first_mut() {
            later.iter_mut().zip(v.iter().zip(&self.earlier)).for_each(|(o, (x, b))| *o -= b * x);
        }
        out
    }

    /// The weight of a row in its own whitened value.
    pub fn weight(&self, row: usize) -> f64 {
        self.own[row]
    }

    /// The transpose of [`Whitener::whiten`].
    pub fn transposed(&self, v: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = v.iter().zip(&self.own).map(|(x, a)| x * a).collect();
        let later = v.iter().skip(1).zip(&self.earlier);
        out.iter_mut().zip(later).for_each(|(o, (x, b))| *o -= b * x);
        out
    }

    /// For every row the squared length of the whitened step that begins there.
    pub fn squared_lengths_of_steps(&self) -> Vec<f64> {
        // The first row of a step has nothing before it; every later one is less what it has of the one before.
        let mut later = 0.0;
        let mut out = vec![0.0; self.own.len()];
        for i in (0..out.len()).rev() {
            out[i] = later + self.own[i] * self.own[i];
            let before = if i > 0 { self.earlier.get(i - 1).copied().unwrap_or(0.0) } else { 0.0 };
            later += (self.own[i] - before).powi(2);
        }
        out
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
    let mut white = Columns::new(n);
    for k in 0..columns.count() {
        white.push(&correlation.whiten(columns.get(k).iter().copied()));
    }
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

    use super::Correlation;

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
        let correlation = Correlation::none(&times()).with(20.0);
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
            let clean = none.with(35.0).colour(white(840, seed).into_iter());
            let posterior = none.posterior(&clean, &model, &shape);
            let found = none.mean(&posterior).time;
            // Some sixty independent stretches determine τ to about a quarter: two and a half of those.
            assert!((0.5 * 35.0..2.2 * 35.0).contains(&found), "{found}");
            let uncorrelated = none.posterior(&white(840, seed), &model, &shape);
            assert!(none.mean(&uncorrelated).typical() < 0.15);
        }
    }

    #[test]
    fn many_rows_leave_no_doubt_however_likely() {
        let n = 2400;
        let none = Correlation::none(&(0..n).map(|i| 0.05 * i as f64).collect::<Vec<f64>>());
        let clean = none.with(40.0).colour(white(n, 7).into_iter());
        let posterior = none.posterior(&clean, &[vec![1.0; n]], &vec![1.0; n]);
        // Sixty stretches of the memory's length: the time constant is known to a third.
        let near: f64 = posterior.iter().filter(|(t, _)| (20.0..80.0).contains(t)).map(|(_, w)| w).sum();
        assert!(near > 0.9, "{posterior:?}");
    }
}
