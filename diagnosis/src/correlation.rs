//! How the noise of readings that follow one another correlates: as e^(−Δt/τ), in time and not from row to
//! row, because a recording may be read fast in one pass, slowly in the next, and pause between them.
//!
//! τ is estimated by restricted maximum likelihood, which allows for the columns that are fitted, and keeps
//! its whole posterior: a test that took the estimate for the truth would raise false alarms. A step or a
//! seat that differs from pass to pass looks like slow noise; where it explains the recording far better than
//! any correlation does, it is taken out first ([`without_jumps`]).

use crate::linear::{Basis, Columns, add_scaled, cholesky, dot, quadratic_form};
use crate::rows::median;

/// Prior probability that readings are uncorrelated.
const PRIOR_UNCORRELATED: f64 = 0.5;
/// Shortest correlation time that is searched, in typical gaps between rows.
const SHORTEST: f64 = 0.3;
/// Points of the grid of correlation times; every so many of them are tried first.
const POINTS: usize = 41;
const COARSE: usize = 5;
/// Log likelihood below the best of the coarse grid at which a neighbourhood is not looked into.
const HOPELESS: f64 = 12.0;
/// Gain in −2 log likelihood, correlation times searched on either side, at which jumps are believed: one
/// column among some hundred by chance once in some thousand recordings.
const JUMP_GAIN: f64 = 18.0;
/// The same for every further column of a group.
const JUMP_GAIN_PER_COLUMN: f64 = 3.0;
/// Most groups of jumps that are taken out.
const MOST_JUMPS: usize = 3;

/// Correlation of every row with the one before, e^(−Δt/τ).
#[derive(Debug, Clone)]
pub struct Correlation {
    /// Time since the previous row in typical gaps; the first row has none.
    gaps: Vec<f64>,
    /// e^(−Δt/τ) of every row; 0 for the first.
    factors: Vec<f64>,
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
        let factors = vec![0.0; t_s.len()];
        Correlation { gaps, factors, time: 0.0 }
    }

    /// The same readings with the correlation time `time` (typical gaps).
    pub fn with(&self, time: f64) -> Correlation {
        let factor = |g: &f64| if time > 0.0 { (-g / time).exp() } else { 0.0 };
        Correlation { gaps: self.gaps.clone(), factors: self.gaps.iter().map(factor).collect(), time }
    }

    /// Correlation of readings one typical gap apart.
    pub fn typical(&self) -> f64 {
        if self.time > 0.0 { (-1.0 / self.time).exp() } else { 0.0 }
    }

    /// Makes values of this correlation white, of the same variance.
    pub fn whiten(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut previous = 0.0;
        values
            .zip(&self.factors)
            .map(|(z, phi)| {
                let u = (z - phi * previous) / (1.0 - phi * phi).sqrt();
                previous = z;
                u
            })
            .collect()
    }

    /// Gives white values this correlation: the inverse of [`Correlation::whiten`].
    pub fn colour(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut previous = 0.0;
        values
            .zip(&self.factors)
            .map(|(w, phi)| {
                previous = phi * previous + (1.0 - phi * phi).sqrt() * w;
                previous
            })
            .collect()
    }

    /// ln det of the correlation matrix.
    fn log_determinant(&self) -> f64 {
        self.factors.iter().map(|phi| (1.0 - phi * phi).ln()).sum()
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
        let columns = scaled_columns(clean, model, shape);
        let at_zero = restricted(&columns, &self.with(0.0));
        let grid = self.grid();
        let at = |k: usize| restricted(&columns, &self.with(grid[k])) - at_zero;
        let mut likelihood: Vec<Option<f64>> =
            (0..POINTS).map(|k| k.is_multiple_of(COARSE).then(|| at(k))).collect();
        let best = likelihood.iter().flatten().copied().fold(f64::NEG_INFINITY, f64::max);
        let hopeful: Vec<bool> =
            likelihood.iter().map(|l| l.is_some_and(|l| l > best - HOPELESS && l > -HOPELESS)).collect();
        for k in 0..POINTS {
            let (before, after) = (k / COARSE * COARSE, (k / COARSE + 1) * COARSE);
            if likelihood[k].is_none() && (hopeful[before] || hopeful.get(after) == Some(&true)) {
                likelihood[k] = Some(at(k));
            }
        }
        let weights: Vec<f64> = likelihood.iter().map(|l| l.map_or(0.0, |l| l.min(600.0).exp())).collect();
        let slab = weights.iter().sum::<f64>() / POINTS as f64;
        let total = PRIOR_UNCORRELATED + (1.0 - PRIOR_UNCORRELATED) * slab;
        let mut posterior = vec![(0.0, PRIOR_UNCORRELATED / total)];
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

    /// The groups of `suspects` (each a number of columns) that explain the observations so much better than
    /// correlation alone can that they are no noise.
    pub fn without_jumps(
        &self,
        clean: &[f64],
        model: &[Vec<f64>],
        shape: &[f64],
        suspects: &[Vec<Vec<f64>>],
    ) -> Vec<usize> {
        let grid = self.grid();
        let times = std::iter::once(0.0).chain(grid.into_iter().step_by(COARSE));
        let n = clean.len();
        // Per correlation time: basis, residual, and −2 log likelihood of the profile.
        let mut places: Vec<(Correlation, Basis, Vec<f64>)> = times
            .map(|time| {
                let here = self.with(time);
                let white = |v: &Vec<f64>| here.whiten(v.iter().zip(shape).map(|(v, s)| v / s));
                let mut basis = Basis::new(n);
                model.iter().for_each(|c| {
                    basis.add(&white(c));
                });
                let mut residual = white(&clean.to_vec());
                basis.project_off(&mut residual);
                (here, basis, residual)
            })
            .collect();
        let deviance = |here: &Correlation, rank: usize, rss: f64| {
            here.log_determinant() + (n.saturating_sub(rank)).max(1) as f64 * rss.max(1e-300).ln()
        };
        let mut taken = Vec::new();
        while taken.len() < MOST_JUMPS {
            let before = places
                .iter()
                .map(|(here, basis, r)| deviance(here, basis.rank(), dot(r, r)))
                .fold(f64::INFINITY, f64::min);
            let mut best: Option<(f64, usize)> = None;
            for (k, group) in suspects.iter().enumerate().filter(|(k, _)| !taken.contains(k)) {
                let asked = JUMP_GAIN + JUMP_GAIN_PER_COLUMN * (group.len() as f64 - 1.0);
                for (here, basis, residual) in &places {
                    let rss = dot(residual, residual);
                    let explained = explained_by(here, basis, residual, group, shape);
                    let gain = before - deviance(here, basis.rank() + group.len(), rss - explained) - asked;
                    if gain > 0.0 && best.is_none_or(|b| gain > b.0) {
                        best = Some((gain, k));
                    }
                }
            }
            let Some((_, k)) = best else { break };
            taken.push(k);
            for (here, basis, residual) in &mut places {
                for column in &suspects[k] {
                    let rank = basis.rank();
                    if basis.add(&here.whiten(column.iter().zip(shape).map(|(v, s)| v / s))) {
                        let q = basis.columns.get(rank);
                        let a = dot(q, residual);
                        add_scaled(residual, -a, q);
                    }
                }
            }
        }
        taken
    }
}

/// What a group explains of a whitened residual beside a basis.
fn explained_by(
    here: &Correlation,
    basis: &Basis,
    residual: &[f64],
    group: &[Vec<f64>],
    shape: &[f64],
) -> f64 {
    let mut own = Basis::new(residual.len());
    for column in group {
        let mut w = here.whiten(column.iter().zip(shape).map(|(v, s)| v / s));
        let length = dot(&w, &w).sqrt();
        basis.project_off(&mut w);
        if dot(&w, &w).sqrt() > 0.02 * length {
            own.add(&w);
        }
    }
    (0..own.rank()).map(|k| dot(own.columns.get(k), residual).powi(2)).sum()
}

/// The model's columns and the observations (last), each divided by `shape` and of unit length: only the
/// data's own scale matters to the likelihood, and the factor stays well scaled.
fn scaled_columns(clean: &[f64], model: &[Vec<f64>], shape: &[f64]) -> Columns {
    let mut columns = Columns::new(clean.len());
    for column in model.iter().map(|c| c.as_slice()).chain([clean]) {
        let scaled: Vec<f64> = column.iter().zip(shape).map(|(v, s)| v / s).collect();
        let length = dot(&scaled, &scaled).sqrt().max(1e-300);
        columns.push(&scaled.iter().map(|v| v / length).collect::<Vec<f64>>());
    }
    columns
}

/// Restricted log likelihood of a correlation; the last column holds the observations.
fn restricted(columns: &Columns, correlation: &Correlation) -> f64 {
    let n = columns.rows;
    let mut white = Columns::new(n);
    for k in 0..columns.count() {
        white.push(&correlation.whiten(columns.get(k).iter().copied()));
    }
    let m = white.count();
    let p = m - 1;
    let gram = white.products(&white);
    let xx: Vec<f64> = (0..p * p).map(|i| gram[(i % p) * m + i / p]).collect();
    let xy: Vec<f64> = (0..p).map(|k| gram[p * m + k]).collect();
    let (factor, log_determinant) = cholesky(&xx, p);
    let rank = (0..p).filter(|k| factor[k * p + k].is_finite()).count();
    let left = (gram[p * m + p] - quadratic_form(&factor, &xy)).max(1e-300);
    -0.5 * (correlation.log_determinant() + log_determinant + (n - rank) as f64 * left.ln())
}
