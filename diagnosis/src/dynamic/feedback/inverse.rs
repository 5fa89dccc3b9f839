//! The inverse model: the drive that the recorded motion needs, linear in everything but the shapes of the
//! effects and the lag. Drive and regressors pass the same zero-phase filter, so that no derivative of the
//! reading noise reaches the estimate (IDIM-LS: Janot, Vandanjon & Gautier, IEEE Trans. Control Syst.
//! Technol. 22 (2014)).

use fitter::plant::Hold;

use super::motion::Motion;
use crate::dynamic::effects::{DynamicEffect, Part};
use crate::dynamic::model::Model;
use crate::dynamic::recording::DynamicRecording;
use crate::numerics::{Symmetric, widening};
use crate::thresholds::dynamic::feedback::inverse::{PARTS, ROUNDS};

/// A mechanism without effects, with or without a stiffness; what multiplies follows by least squares.
pub fn mechanism(stiffness: bool) -> Model {
    Model { nominal_free: [true, stiffness, true], ..Model::nominal([0.0; 3], Hold::ZeroOrder) }
}

/// A column of the drive, and of which term's which parameter it is; of none: nominal.
type Column = (Vec<f64>, Option<(usize, usize)>);

/// An inverse model that was fitted.
#[derive(Clone)]
pub struct Solved {
    /// The model, with amounts.
    pub model: Model,
    /// Drive less prediction, both smoothed, all rows.
    pub residual: Vec<f64>,
    /// Standard deviations of damping, stiffness and gain, then of every term's parameters: from white noise below the
    /// cut-off, or from how much successive parts of the recording disagree, whichever is more.
    pub deviations: Vec<Vec<f64>>,
    /// The same from white noise alone: what is left of structure is the same along the same motion.
    pub of_noise: Vec<Vec<f64>>,
}

/// The drive that a motion needs by a model: f + τ f′ + offset with f = (x″ + d v + k x − effects)/gain.
pub fn predict(model: &Model, motion: &Motion) -> Vec<f64> {
    let [damping, stiffness, gain] = model.nominal;
    let mut force: Vec<f64> = (0..motion.position.len())
        .map(|k| motion.acceleration[k] + damping * motion.velocity[k] + stiffness * motion.position[k])
        .collect();
    let (mut lag, mut offset) = (0.0, 0.0);
    for term in &model.terms {
        match term.effect.part {
            Part::Force => {
                for (f, a) in force.iter_mut().zip(motion.force(term.effect, &term.parameters, gain)) {
                    *f -= a;
                }
            }
            Part::Drive => offset += term.parameters[0],
            Part::SensorOffset => offset += stiffness * term.parameters[0] / gain,
            _ => lag += term.parameters[0],
        }
    }
    force.iter_mut().for_each(|f| *f /= gain);
    let rate = motion.rate(&force);
    force.iter().zip(&rate).map(|(f, r)| f + lag * r + offset).collect()
}

/// Columns of acceleration, velocity and, where wanted, position: linear in the position, which has passed
/// the filter.
fn nominal_columns(stiffness: bool, motion: &Motion) -> Vec<Vec<f64>> {
    let mut columns = vec![motion.acceleration.clone(), motion.velocity.clone()];
    if stiffness {
        columns.push(motion.position.clone());
    }
    columns
}

/// Smoothed columns of an effect that is no lag, one per amount, with the parameter's number.
pub fn effect_columns(
    effect: &DynamicEffect,
    shapes: &[f64],
    motion: &Motion,
    gain: f64,
) -> Vec<(usize, Vec<f64>)> {
    if effect.part != Part::Force {
        return vec![(0, vec![1.0; motion.position.len()])];
    }
    let amounts: Vec<usize> = (0..shapes.len()).filter(|j| !effect.parameters[*j].shape).collect();
    let one = |j: &usize| {
        let mut unit = shapes.to_vec();
        amounts.iter().for_each(|i| unit[*i] = f64::from(i == j));
        let column: Vec<f64> = motion.force(effect, &unit, gain).iter().map(|a| -a).collect();
        (*j, motion.smooth(&column))
    };
    amounts.iter().map(one).collect()
}

/// The normal equations of the drive in some columns on some rows, and their right-hand side.
fn normal_equations(columns: &[Column], rows: &[usize], drive: &[f64]) -> (Symmetric, Vec<f64>) {
    let n = columns.len();
    let mut normal = Symmetric::zero(n);
    let mut right = vec![0.0; n];
    for &k in rows {
        for i in 0..n {
            right[i] += columns[i].0[k] * drive[k];
            for j in 0..=i {
                *normal.at_mut(i, j) += columns[i].0[k] * columns[j].0[k];
            }
        }
    }
    for i in 0..n {
        for j in i + 1..n {
            *normal.at_mut(i, j) = normal.at(j, i);
        }
    }
    (normal, right)
}

/// Standard deviations of sums of coefficients.
fn deviations(sums: &[Vec<Vec<(usize, f64)>>], covariance: &Symmetric) -> Vec<Vec<f64>> {
    let one = |weights: &Vec<(usize, f64)>| {
        let pairs = weights.iter().flat_map(|a| weights.iter().map(move |b| (a, b)));
        let variance: f64 = pairs.map(|((i, a), (j, b))| a * b * covariance.at(*i, *j)).sum();
        variance.max(0.0).sqrt()
    };
    sums.iter().map(|of_term| of_term.iter().map(one).collect()).collect()
}

/// Covariance of the coefficients by how much successive parts of the rows disagree: it holds whatever the residual is
/// correlated with within a part, and where structure is left. The sandwich of White, clustered, with the correction for few
/// parts (Cameron & Miller, A practitioner's guide to cluster-robust inference, J. Human Resources 50 (2015) 317–372).
fn scatter(columns: &[Column], rows: &[usize], residual: &[f64], inverse: &Symmetric) -> Symmetric {
    let n = columns.len();
    let mut sum = Symmetric::zero(n);
    let parts = rows.chunks(rows.len().div_ceil(PARTS).max(1));
    let count = parts.len() as f64;
    for part in parts {
        let pull: Vec<f64> =
            columns.iter().map(|(column, _)| part.iter().map(|k| column[*k] * residual[*k]).sum()).collect();
        let moved: Vec<f64> = (0..n).map(|i| (0..n).map(|j| inverse.at(i, j) * pull[j]).sum()).collect();
        for i in 0..n {
            for j in 0..n {
                *sum.at_mut(i, j) += moved[i] * moved[j];
            }
        }
    }
    // Of so few parts a normal interval is too narrow.
    let few = count / (count - 1.0).max(1.0) * widening(count - 1.0).powi(2);
    sum.entries.iter_mut().for_each(|entry| *entry *= few);
    sum
}

/// Fits the amounts of a model, its shapes given, on the rows that `wanted` selects.
pub fn solve(shapes: &Model, motion: &Motion, wanted: &dyn Fn(usize) -> bool) -> Option<Solved> {
    let (terms, stiff) = (&shapes.terms, shapes.nominal_free[1]);
    let rows: Vec<usize> = motion.runs.iter().flat_map(|r| r.clone()).filter(|k| wanted(*k)).collect();
    // Only a lag and a force that goes with the gain have to settle.
    let rounds = if terms.iter().all(|t| !t.effect.is_late() && !t.effect.by_gain) { 1 } else { ROUNDS };
    let mut gain = 1.0;
    let mut lag_column: Option<Vec<f64>> = None;
    let mut solved = None;
    for _ in 0..rounds {
        // Columns of the drive: acceleration, velocity, position, then every amount; with its owner.
        let mut columns: Vec<Column> =
            nominal_columns(stiff, motion).into_iter().map(|c| (c, None)).collect();
        for (t, term) in terms.iter().enumerate() {
            if term.effect.is_late() {
                columns.extend(lag_column.iter().map(|rate| (rate.clone(), Some((t, 0)))));
                continue;
            }
            let own = effect_columns(term.effect, &term.parameters, motion, gain);
            columns.extend(own.into_iter().map(|(j, c)| (c, Some((t, j)))));
        }
        let (normal, right) = normal_equations(&columns, &rows, &motion.drive);
        let factor = normal.factor();
        let x = factor.solve(&right);
        if x[0] == 0.0 || x.iter().any(|v| !v.is_finite()) {
            return None;
        }
        gain = 1.0 / x[0];
        let without_lag: Vec<f64> = (0..motion.position.len())
            .map(|k| {
                let own = columns
                    .iter()
                    .zip(&x)
                    .filter(|((_, owner), _)| owner.is_none_or(|(t, _)| terms[t].effect.part == Part::Force));
                own.map(|((c, _), x)| c[k] * x).sum()
            })
            .collect();
        lag_column = Some(motion.rate(&without_lag));
        let residual: Vec<f64> = (0..motion.position.len())
            .map(|k| motion.drive[k] - columns.iter().zip(&x).map(|((c, _), x)| c[k] * x).sum::<f64>())
            .collect();
        let square = rows.iter().map(|k| residual[*k].powi(2)).sum::<f64>() / rows.len().max(1) as f64;
        let per_row = (2.0 * motion.cutoff_hz * motion.step_s).min(1.0);
        let inverse_normal = factor.inverse();
        let mut model = shapes.clone();
        model.nominal = [x[1] * gain, if stiff { x[2] * gain } else { 0.0 }, gain];
        // A coefficient per inertia, which is itself estimated.
        let by_gain = |i: usize| vec![(i, gain), (0, -x[i] * gain * gain)];
        // Of damping, stiffness and gain, then of every term's parameters: the sum of coefficients that it is by the slopes.
        let mut sums =
            vec![vec![by_gain(1), if stiff { by_gain(2) } else { Vec::new() }, vec![(0, gain * gain)]]];
        sums.extend(terms.iter().map(|t| vec![Vec::new(); t.parameters.len()]));
        for (i, (_, owner)) in columns.iter().enumerate() {
            let Some((t, j)) = *owner else { continue };
            let factor = match terms[t].effect.part {
                Part::Force => gain,
                Part::SensorOffset if stiff => x[0] / x[2],
                _ => 1.0,
            };
            model.terms[t].parameters[j] = x[i] * factor;
            let force = terms[t].effect.part == Part::Force;
            sums[1 + t][j] = if force { by_gain(i) } else { vec![(i, factor)] };
        }
        let mut of_noise = inverse_normal.clone();
        of_noise.entries.iter_mut().for_each(|entry| *entry *= square / per_row);
        let of_noise = deviations(&sums, &of_noise);
        let of_parts = deviations(&sums, &scatter(&columns, &rows, &residual, &inverse_normal));
        let more = |(noise, parts): (&Vec<f64>, Vec<f64>)| {
            noise.iter().zip(parts).map(|(noise, parts)| noise.max(parts)).collect()
        };
        let deviations = of_noise.iter().zip(of_parts).map(more).collect();
        solved = Some(Solved { model, residual, deviations, of_noise });
    }
    solved
}

/// Smoothed columns of a whole model that was fitted, its lag included.
pub fn model_columns(solved: &Solved, motion: &Motion) -> Vec<Vec<f64>> {
    let mut columns = nominal_columns(solved.model.nominal_free[1], motion);
    for term in &solved.model.terms {
        if term.effect.is_late() {
            let fitted: Vec<f64> = motion.drive.iter().zip(&solved.residual).map(|(u, r)| u - r).collect();
            columns.push(motion.rate(&fitted));
        } else {
            let own = effect_columns(term.effect, &term.parameters, motion, solved.model.nominal[2]);
            columns.extend(own.into_iter().map(|(_, c)| c));
        }
    }
    columns
}

/// A recording's own smoothing: the cut-off at which the nominal prediction with dry friction and offset
/// errs least against the raw drive.
pub fn best_cutoff(recording: &DynamicRecording, shapes: &Model) -> f64 {
    let rate = 1.0 / recording.step_s;
    let tried = (0..12).map(|k| rate / 8.0 * 0.7f64.powi(k));
    let error = |cutoff: f64| -> f64 {
        let motion = Motion::new(recording, cutoff, None);
        let Some(solved) = solve(shapes, &motion, &|_| true) else { return f64::INFINITY };
        let predicted = predict(&solved.model, &motion);
        predicted.iter().zip(&recording.drives[0]).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let all: Vec<(f64, f64)> = tried.map(|c| (error(c), c)).collect();
    all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(rate / 20.0, |(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::{Column, PARTS, normal_equations, scatter};

    #[test]
    fn parts_that_disagree_make_a_coefficient_uncertain() {
        let rows: Vec<usize> = (0..4000).collect();
        let columns: Vec<Column> = vec![(vec![1.0; 4000], None)];
        let inverse = normal_equations(&columns, &rows, &[0.0; 4000]).0.factor().inverse();
        let deviation = |residual: &dyn Fn(usize) -> f64| {
            let residual: Vec<f64> = (0..4000).map(residual).collect();
            scatter(&columns, &rows, &residual, &inverse).at(0, 0).sqrt()
        };
        // Every part is off by 1, to one side or the other: the mean of so many parts has an error of 1/√PARTS.
        let apart = deviation(&|k| if (k / (4000 / PARTS)).is_multiple_of(2) { 1.0 } else { -1.0 });
        let mean = 1.0 / (PARTS as f64).sqrt();
        assert!((1.0..1.2).contains(&(apart / mean)), "{apart} for {mean}");
        // The same within every part.
        assert!(deviation(&|k| if k.is_multiple_of(2) { 1.0 } else { -1.0 }) < 1e-9);
    }
}
