//! The noise floor and its covariance, from the recording itself: the scatter about a saturated model
//! (base, every angle by itself, smooth in time, linear in every observable), robust against outliers,
//! with a variance that may change along the recording or in bursts, and an autocorrelation from row to row.
//!
//! Covariance: Σ = D R D, D = diag(σᵢ), R of a stationary process that is forgotten with one time constant (see
//! [`crate::correlation`]).

use numerics::{Basis, dot, median};

use crate::bursts;
use crate::correlation::{Correlation, Process, Whitener, suspect};
use crate::thresholds::noise::bursts::MOST_REMEMBERED;
use crate::thresholds::noise::{ALONE, HAMPEL, MOST_CLEANED, VARIANCE_GAIN};

/// The noise of a recording.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Standard deviation of every row as far as estimates from the cleaned observations are concerned.
    pub sigma: Vec<f64>,
    /// Root mean square of the cleaned observations' noise.
    pub level: f64,
    /// The same of the observations as they were read, outliers and all: the floor.
    pub as_read: f64,
    /// Correlation used for whitening (posterior mean).
    pub correlation: Correlation,
    /// Posterior of the process, the soonest forgotten first: weights that sum to one.
    pub posterior: Vec<(Process, f64)>,
    /// Degrees of freedom of the estimate of the overall level.
    pub freedom: f64,
    /// The observations with gross outliers moved to where the influence function puts them.
    pub clean: Vec<f64>,
    /// Whitened residual of the saturated model, of variance one: what resampling draws from.
    pub whitened_residual: Vec<f64>,
}

impl Noise {
    /// Makes noise white: each row divided by its σ, less what it has of its predecessor, scaled to variance
    /// one.
    pub fn whiten(&self, v: &[f64]) -> Vec<f64> {
        self.whitener().whiten(v)
    }

    /// The same for many columns.
    pub fn whitener(&self) -> Whitener {
        self.correlation.whitener(&self.sigma)
    }
}

/// What observations are, and what is left of them.
#[derive(Clone, Copy, PartialEq)]
pub enum Sort {
    /// Readings one by one.
    Readings,
    /// Means over several readings, in which a burst is no stretch of its own.
    Means,
    /// Structure rather than noise: it has no memory, and its strong parts are no bursts.
    Structure,
}

/// [`estimate_with`] where what is left is structure rather than noise: without a memory.
pub fn estimate_white(y: &[f64], t_s: &[f64], model: &[Vec<f64>], covariates: &[Vec<f64>]) -> Noise {
    estimate_with(y, t_s, model, model, covariates, &[], Sort::Structure)
}

/// Estimates the noise of `y`, read at `t_s`, about the span of `model` (raw columns). `covariates` are what
/// the variance may depend on, centred; a dependence is kept only where it improves the likelihood clearly.
/// `slow` are groups of columns that would be taken for correlated noise if they were left in; they and a step
/// at any row (none without such groups) are looked for beside the model, and beside `light`, the least model,
/// because a model that follows slow changes closely hides a jump nearly as well as correlation does.
pub fn estimate_with(
    y: &[f64],
    t_s: &[f64],
    model: &[Vec<f64>],
    light: &[Vec<f64>],
    covariates: &[Vec<f64>],
    slow: &[Vec<Vec<f64>>],
    sort: Sort,
) -> Noise {
    let n = y.len();
    let mut shape = vec![1.0; n];
    let (mut basis, mut clean) = robust_fit(y, model, &shape);
    let correlation = Correlation::none(t_s);
    let mut model = model.to_vec();
    let mut taken = correlation.mistaken(&clean, &model, &shape, slow);
    if light.len() < model.len() {
        taken.extend(correlation.mistaken(&clean, light, &shape, slow));
        taken.sort_unstable();
        taken.dedup();
    }
    if !taken.is_empty() {
        model.extend(taken.iter().flat_map(|k| suspect(slow, *k, n)));
        (basis, clean) = robust_fit(y, &model, &shape);
    }
    let model = &model;
    let residual = standardised(&clean, &basis, &shape);
    let fitted = variance_shape(&what_is_new(&correlation, residual, &basis), covariates);
    if fitted.iter().any(|s| (s - 1.0).abs() > 1e-9) {
        shape = fitted;
        (basis, clean) = robust_fit(y, model, &shape);
    }
    if sort == Sort::Readings
        && let Some(fitted) = with_bursts(y, &clean, &correlation, &basis, &shape)
    {
        shape = fitted;
        (basis, clean) = robust_fit(y, model, &shape);
    }
    let residual = standardised(&clean, &basis, &shape);
    let posterior = match sort {
        Sort::Readings | Sort::Means => correlation.posterior(&clean, model, &shape),
        Sort::Structure => vec![(Process::white(), 1.0)],
    };
    let correlation = correlation.with(&Process::mean(&posterior));

    let outliers = outlier_factor(y, &clean, &residual, &shape);

    // The overall level about the whitened saturated model.
    let unit = Noise {
        sigma: shape.clone(),
        correlation,
        posterior,
        freedom: 1.0,
        level: 0.0,
        as_read: 0.0,
        clean,
        whitened_residual: residual,
    };
    let whitener = unit.whitener();
    let mut whitened = Basis::new(n);
    for column in model {
        whitened.add(&whitener.whiten(column));
    }
    let mut r = whitener.whiten(&unit.clean);
    whitened.project_off(&mut r);
    let freedom = (n - whitened.rank()).max(1) as f64;
    let scale = (dot(&r, &r) / freedom).sqrt().max(1e-300);
    let price = cost_of_cleaning(y, &unit, scale, whitened.rank());
    // Leverage shrinks each residual: give it back its variance.
    for (i, r) in r.iter_mut().enumerate() {
        let leverage: f64 = (0..whitened.rank()).map(|k| whitened.columns.get(k)[i].powi(2)).sum();
        *r /= scale * (1.0 - leverage).max(0.05).sqrt();
    }
    let level = numerics::rms(&unit.sigma) * scale;
    Noise {
        sigma: unit.sigma.iter().map(|s| s * scale * price).collect(),
        level,
        as_read: level * outliers,
        freedom,
        whitened_residual: r,
        ..unit
    }
}

/// σ at every row with the bursts that the observations show as they were read; none where they show none.
fn with_bursts(
    y: &[f64],
    clean: &[f64],
    none: &Correlation,
    basis: &Basis,
    shape: &[f64],
) -> Option<Vec<f64>> {
    let mut residual = standardised(clean, basis, shape);
    for (((residual, y), clean), shape) in residual.iter_mut().zip(y).zip(clean).zip(shape) {
        *residual += (y - clean) / shape;
    }
    let mut absolute: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
    let far = HAMPEL.0 * 1.482_6 * median(&mut absolute);
    // What something holds up for a while is no burst.
    let apart = |i: usize| if residual[i].abs() > far { alone(&residual, i) } else { residual[i] };
    let apart: Vec<f64> = (0..residual.len()).map(apart).collect();
    // Where noise remembers, a stretch far off looks like one that is loud.
    if of_predecessor(&apart) > MOST_REMEMBERED {
        return None;
    }
    let louder = bursts::louder(&what_is_new(none, apart, basis))?;
    Some(louder.iter().zip(shape).map(|(louder, shape)| louder * shape).collect())
}

/// How many times the noise of cleaned observations that of the observations as they were read is. An outlier lies as far from
/// the model as what is left of it and how far it was moved together. `residual` is that of `clean` in units of `shape`.
fn outlier_factor(y: &[f64], clean: &[f64], residual: &[f64], shape: &[f64]) -> f64 {
    let (mut read, mut cleaned) = (0.0, 0.0);
    for (((y, clean), residual), shape) in y.iter().zip(clean).zip(residual).zip(shape) {
        read += (residual * shape + (y - clean)).powi(2);
        cleaned += (residual * shape).powi(2);
    }
    (read / cleaned.max(1e-300)).sqrt()
}

/// What an influence function costs: the estimates' variance is E ψ²/(E ψ′)² (Huber, Robust Statistics, 1981, section 7.6,
/// with his correction for the number of fitted columns, here `rank`).
fn cost_of_cleaning(y: &[f64], unit: &Noise, scale: f64, rank: usize) -> f64 {
    let n = y.len() as f64;
    let slopes: Vec<f64> = y
        .iter()
        .zip(&unit.clean)
        .zip(&unit.sigma)
        .map(|((y, c), s)| hampel_slope((y - c) / (scale * s)))
        .collect();
    let slope = numerics::mean(&slopes).max(0.2);
    let spread = slopes.iter().map(|v| (v - slope).powi(2)).sum::<f64>() / n;
    (1.0 + rank as f64 / n * spread / (slope * slope)) / slope
}

/// Residual of `clean` in units of `shape`.
fn standardised(clean: &[f64], basis: &Basis, shape: &[f64]) -> Vec<f64> {
    let mut r: Vec<f64> = clean.iter().zip(shape).map(|(y, s)| y / s).collect();
    basis.project_off(&mut r);
    r
}

/// Weighted fit with outliers pulled in; returns the weighted basis and the cleaned observations.
fn robust_fit(y: &[f64], model: &[Vec<f64>], shape: &[f64]) -> (Basis, Vec<f64>) {
    let n = y.len();
    let mut basis = Basis::new(n);
    for column in model {
        basis.add(&column.iter().zip(shape).map(|(v, s)| v / s).collect::<Vec<f64>>());
    }
    let target: Vec<f64> = y.iter().zip(shape).map(|(v, s)| v / s).collect();
    let mut pseudo = target.clone();
    for _ in 0..6 {
        let mut from_fit = pseudo.clone();
        basis.project_off(&mut from_fit);
        // Residual of the true observation about the fit to the cleaned ones.
        let residual: Vec<f64> =
            target.iter().zip(&pseudo).zip(&from_fit).map(|((t, p), r)| t - (p - r)).collect();
        let mut absolute: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
        let freedom = (n as f64 - basis.rank() as f64).max(1.0) / n as f64;
        let central = 1.482_6 * median(&mut absolute);
        // More than a tenth of the rows are no outliers but structure: they must not be cleaned away.
        let ninth = absolute.len() * 9 / 10;
        let (_, outer, _) = absolute.select_nth_unstable_by(ninth, f64::total_cmp);
        let scale = central.max(*outer / MOST_CLEANED) / freedom.sqrt();
        if scale.is_nan() || scale <= 0.0 {
            break;
        }
        for i in 0..n {
            let apart = alone(&residual, i);
            pseudo[i] = target[i] - apart + scale * hampel(apart / scale);
        }
    }
    (basis, pseudo.iter().zip(shape).map(|(v, s)| v * s).collect())
}

/// How far a row's residual lies from nothing, or from those read just before and after it, whichever is nearer: an
/// outlier is alone, and a run that noise with a memory or a step makes is none.
fn alone(residual: &[f64], i: usize) -> f64 {
    let first = i.saturating_sub(ALONE).min(residual.len().saturating_sub(2 * ALONE + 1));
    let mut near: Vec<f64> = residual[first..].iter().take(2 * ALONE + 1).copied().collect();
    let from_them = residual[i] - median(&mut near);
    if from_them.abs() < residual[i].abs() { from_them } else { residual[i] }
}

/// Hampel's influence function.
fn hampel(z: f64) -> f64 {
    let (a, b, c) = HAMPEL;
    let size = z.abs();
    let value = if size <= a {
        size
    } else if size <= b {
        a
    } else if size <= c {
        a * (c - size) / (c - b)
    } else {
        0.0
    };
    value.copysign(z)
}

/// Slope of Hampel's function at a row, from how far the row was moved: 1 where it was left alone.
fn hampel_slope(moved: f64) -> f64 {
    let (a, b, c) = HAMPEL;
    let moved = moved.abs();
    if moved < 1e-12 {
        1.0
    } else if moved <= b - a {
        0.0
    } else if moved < c {
        -a / (c - b)
    } else {
        0.0
    }
}

/// Squares of what is new in each residual about `basis`, each given back what the fit took of it. By the
/// correlation from row to row every residual has a part of its predecessor; the squares of correlated residuals go
/// together, and a slow covariate would follow them by chance.
fn what_is_new(none: &Correlation, residual: Vec<f64>, basis: &Basis) -> Vec<f64> {
    let given_back = |residual: &[f64], basis: &Basis| -> Vec<f64> {
        let leverage = |i: usize| (0..basis.rank()).map(|k| basis.columns.get(k)[i].powi(2)).sum::<f64>();
        residual.iter().enumerate().map(|(i, r)| r * r / (1.0 - leverage(i)).max(0.2)).collect()
    };
    let typical = of_predecessor(&residual);
    if typical <= 0.0 {
        return given_back(&residual, basis);
    }
    let correlation = none.with(&Process::slow(1.0, -1.0 / typical.min(0.999).ln()));
    let mut whitened = Basis::new(residual.len());
    for k in 0..basis.rank() {
        whitened.add(&correlation.whiten(basis.columns.get(k).iter().copied()));
    }
    let mut new = correlation.whiten(residual.into_iter());
    whitened.project_off(&mut new);
    given_back(&new, &whitened)
}

/// The part that a residual has of its predecessor.
fn of_predecessor(residual: &[f64]) -> f64 {
    let lagged: f64 = residual.windows(2).map(|w| w[0] * w[1]).sum();
    lagged / dot(residual, residual).max(1e-300)
}

/// σ relative to its geometric mean at every row, from the squares of the residuals: log σ² linear in the
/// covariates that earn it.
fn variance_shape(squares: &[f64], covariates: &[Vec<f64>]) -> Vec<f64> {
    let n = squares.len();
    let fit = |chosen: &[usize]| -> (f64, Vec<f64>) {
        // Fisher scoring of the gamma likelihood with a log link; the information is ZᵀZ/2, constant.
        let mut z: Vec<Vec<f64>> = vec![vec![1.0; n]];
        z.extend(chosen.iter().map(|&k| covariates[k].clone()));
        let mut q = Basis::new(n);
        z.iter().for_each(|c| {
            q.add(c);
        });
        let mean = (squares.iter().sum::<f64>() / n as f64).max(1e-300);
        let mut log_variance = vec![mean.ln(); n];
        for _ in 0..12 {
            let mut score: Vec<f64> =
                (0..n).map(|i| (squares[i] / log_variance[i].exp()).min(30.0) - 1.0).collect();
            let whole = score.clone();
            q.project_off(&mut score);
            for i in 0..n {
                log_variance[i] += (whole[i] - score[i]).clamp(-1.0, 1.0);
            }
        }
        let deviance = (0..n).map(|i| log_variance[i] + squares[i] / log_variance[i].exp()).sum::<f64>();
        (deviance, log_variance)
    };
    let mut chosen: Vec<usize> = Vec::new();
    let (mut deviance, mut log_variance) = fit(&chosen);
    while chosen.len() < 3 {
        let next = (0..covariates.len())
            .filter(|k| !chosen.contains(k))
            .map(|k| {
                let mut with = chosen.clone();
                with.push(k);
                (k, fit(&with))
            })
            .min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        match next {
            Some((k, (d, l))) if d < deviance - VARIANCE_GAIN => {
                chosen.push(k);
                deviance = d;
                log_variance = l;
            }
            _ => break,
        }
    }
    let centre = numerics::mean(&log_variance);
    log_variance.iter().map(|l| (0.5 * (l - centre)).clamp(-2.5, 2.5).exp()).collect()
}

/// [`estimate_with`] of readings.
#[cfg(test)]
pub fn estimate(
    y: &[f64],
    t_s: &[f64],
    model: &[Vec<f64>],
    light: &[Vec<f64>],
    covariates: &[Vec<f64>],
    slow: &[Vec<Vec<f64>>],
) -> Noise {
    estimate_with(y, t_s, model, light, covariates, slow, Sort::Readings)
}

#[cfg(test)]
mod tests {
    use super::{estimate_white, robust_fit};
    use crate::correlation::tests::white;

    #[test]
    fn an_outlier_is_drawn_in_and_a_run_is_left() {
        let n = 120;
        let mut y = white(n, 3);
        y[30] += 9.0;
        // Ten rows that something holds up by nine standard deviations, and no model has.
        y.iter_mut().skip(60).take(10).for_each(|y| *y += 9.0);
        let (_, clean) = robust_fit(&y, &[vec![1.0; n]], &vec![1.0; n]);
        assert!(y[30] - clean[30] > 5.0, "{} {}", y[30], clean[30]);
        let moved = (0..n).filter(|i| *i != 30 && (y[*i] - clean[*i]).abs() > 0.5).count();
        assert!(moved <= 2, "{moved}");
    }

    #[test]
    fn outliers_count_fully_in_noise_as_it_was_read() {
        let n = 400;
        let t_s: Vec<f64> = (0..n).map(|k| k as f64).collect();
        // Every tenth reading scatters by three standard deviations: little of it is cleaned away.
        let y: Vec<f64> =
            white(n, 5).iter().enumerate().map(|(k, e)| if k % 10 == 0 { 3.0 * e } else { *e }).collect();
        let noise = estimate_white(&y, &t_s, &[vec![1.0; n]], &[]);
        let rms = numerics::rms(&numerics::centred(&y));
        assert!(noise.level < 0.97 * rms, "{} of {rms}", noise.level);
        assert!((noise.as_read / rms - 1.0).abs() < 0.01, "{} of {rms}", noise.as_read);
    }
}
