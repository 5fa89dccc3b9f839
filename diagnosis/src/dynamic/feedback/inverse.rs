//! The inverse model: the drive that the recorded motion needs, linear in everything but the shapes of the
//! effects and the lag. Drive and regressors pass the same zero-phase filter, so that no derivative of the
//! reading noise reaches the estimate (IDIM-LS: Janot, Vandanjon & Gautier, IEEE Trans. Control Syst.
//! Technol. 22 (2014)).

use fitter::plant::Hold;
use numerics::Symmetric;

use super::motion::Motion;
use crate::dynamic::effects::{DynamicEffect, Part};
use crate::dynamic::model::Model;
use crate::dynamic::recording::DynamicRecording;
use crate::thresholds::dynamic::feedback::inverse::ROUNDS;

/// A mechanism without effects, with or without a stiffness; what multiplies follows by least squares.
pub fn mechanism(stiffness: bool) -> Model {
    Model { nominal_free: [true, stiffness, true], ..Model::nominal([0.0; 3], Hold::ZeroOrder) }
}

/// A column of the drive, and of which term's which parameter it is; of none: nominal.
pub type Column = (Vec<f64>, Option<(usize, usize)>);

/// An inverse model that was fitted.
#[derive(Clone)]
pub struct Solved {
    /// The model, with amounts.
    pub model: Model,
    /// Drive less prediction, both smoothed, all rows.
    pub residual: Vec<f64>,
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
pub fn normal_equations(columns: &[Column], rows: &[usize], drive: &[f64]) -> (Symmetric, Vec<f64>) {
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

/// Fits the amounts of a model, its shapes given, on those of the rows with motion that `wanted` selects.
pub fn solve(shapes: &Model, motion: &Motion, wanted: &dyn Fn(usize) -> bool) -> Option<Solved> {
    let (terms, stiff) = (&shapes.terms, shapes.nominal_free[1]);
    let rows: Vec<usize> = motion.rows().filter(|k| wanted(*k)).collect();
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
        let mut model = shapes.clone();
        model.nominal = [x[1] * gain, if stiff { x[2] * gain } else { 0.0 }, gain];
        for (i, (_, owner)) in columns.iter().enumerate() {
            let Some((t, j)) = *owner else { continue };
            let factor = match terms[t].effect.part {
                Part::Force => gain,
                Part::SensorOffset if stiff => 1.0 / x[2],
                _ => 1.0,
            };
            model.terms[t].parameters[j] = x[i] * factor;
        }
        solved = Some(Solved { model, residual });
    }
    solved
}

/// Smoothed columns of a whole model that was fitted, its lag included.
pub fn model_columns(solved: &Solved, motion: &Motion) -> Vec<Column> {
    let nominal = nominal_columns(solved.model.nominal_free[1], motion);
    let mut columns: Vec<Column> = nominal.into_iter().map(|column| (column, None)).collect();
    for (t, term) in solved.model.terms.iter().enumerate() {
        if term.effect.is_late() {
            let fitted: Vec<f64> = motion.drive.iter().zip(&solved.residual).map(|(u, r)| u - r).collect();
            columns.push((motion.rate(&fitted), Some((t, 0))));
        } else {
            let own = effect_columns(term.effect, &term.parameters, motion, solved.model.nominal[2]);
            columns.extend(own.into_iter().map(|(j, c)| (c, Some((t, j)))));
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
