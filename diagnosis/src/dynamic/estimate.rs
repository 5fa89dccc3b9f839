//! Output error: the parameters and initial states whose free-run simulation is nearest to the recording,
//! by Levenberg's and Marquardt's method (Marquardt 1963) on exact sensitivities. An unstable simulation is
//! a step that is refused.

use fitter::plant::Hold;
use rayon::prelude::*;

use super::data::{CHOOSE_ROWS, Data, FIT_ROWS, FOLDS, Folds, SCORE_ROWS, over};
use super::gram::grams;
use super::model::Model;
use super::simulate::{Theta, Unstable, simulate};
use crate::thresholds::dynamic::estimate::{ENOUGH, PATIENCE};
use crate::thresholds::dynamic::gram::MOST_FREE;

/// A model with what belongs to this recording, and how well it does.
#[derive(Clone)]
pub struct Fitted {
    pub model: Model,
    /// Position and velocity at the start of every run.
    pub states: Vec<[f64; 2]>,
    /// Sum of squared residuals of every kind of row.
    pub costs: [f64; FOLDS],
    /// Rows of every kind.
    pub rows: [usize; FOLDS],
}

impl Fitted {
    /// Sum of squared residuals of the wanted kinds of rows.
    pub fn cost(&self, folds: Folds) -> f64 {
        over(folds, &self.costs)
    }

    /// Root mean square of the residual of the wanted kinds of rows.
    pub fn rms(&self, folds: Folds) -> f64 {
        (self.cost(folds) / over(folds, &self.rows).max(1) as f64).sqrt()
    }

    /// The simulated positions of all runs, row for row of the recording; NaN in rows of no run.
    ///
    /// # Errors
    /// [`Unstable`].
    pub fn positions(&self, data: &Data) -> Result<Vec<f64>, Unstable> {
        positions(&self.model, &self.states, data)
    }

    /// What it leaves of the recorded positions; none where its simulation is unstable.
    pub fn residual(&self, data: &Data) -> Option<Vec<f64>> {
        let positions = self.positions(data).ok()?;
        Some(data.position.iter().zip(&positions).map(|(a, b)| a - b).collect())
    }
}

/// The simulated positions of all runs, row for row of the recording; NaN in rows of no run.
///
/// # Errors
/// [`Unstable`].
pub fn positions(model: &Model, states: &[[f64; 2]], data: &Data) -> Result<Vec<f64>, Unstable> {
    let theta = Theta::plain(model);
    let mut out = vec![f64::NAN; data.position.len()];
    for (number, (run, state)) in data.runs.iter().zip(states).enumerate() {
        let out = &mut out[run.clone()];
        simulate(model, &theta, &data.course(number, model.hold), *state, &mut |k, y: f64| out[k] = y)?;
    }
    Ok(out)
}

/// Fits a model to the wanted kinds of rows; none where it cannot be simulated at all.
pub fn fit(model: &Model, states: &[[f64; 2]], data: &Data, folds: Folds) -> Option<Fitted> {
    fit_in(PATIENCE, model, states, data, folds)
}

/// The same in each of some ways of running between the samples; those that cannot be simulated are left out.
pub fn fit_in_ways(
    holds: impl IntoParallelIterator<Item = Hold>,
    model: &Model,
    states: &[[f64; 2]],
    data: &Data,
    folds: Folds,
) -> Vec<Fitted> {
    let one = |hold| fit(&Model { hold, ..model.clone() }, states, data, folds);
    holds.into_par_iter().filter_map(one).collect()
}

/// The same in so many steps at most.
pub fn fit_in(
    patience: usize,
    model: &Model,
    states: &[[f64; 2]],
    data: &Data,
    folds: Folds,
) -> Option<Fitted> {
    if model.free() > MOST_FREE {
        return None;
    }
    let mut model = model.clone();
    let mut states = states.to_vec();
    let mut now = grams(&model, &states, data, &[]).ok()?;
    let mut lambda = 1e-3;
    let mut refused = 0;
    for _ in 0..patience {
        let cost = now.cost(folds);
        let (step, moves, promised) = now.step(folds, lambda);
        if promised.is_nan() || promised <= ENOUGH * cost / now.rows(folds).max(1) as f64 {
            break;
        }
        let packed: Vec<f64> = model.pack().iter().zip(&step).map(|(x, d)| x + d).collect();
        let there = model.unpack(&packed);
        let moved: Vec<[f64; 2]> =
            states.iter().zip(&moves).map(|(s, d)| [s[0] + d[0], s[1] + d[1]]).collect();
        match grams(&there, &moved, data, &[]) {
            Ok(next) if next.cost(folds) < cost => {
                let got = cost - next.cost(folds);
                (model, states, now) = (there, moved, next);
                lambda = if got > 0.75 * promised { lambda * 0.1 } else { lambda * 0.5 };
                lambda = f64::max(lambda, 1e-12);
                refused = 0;
            }
            _ => {
                lambda *= if refused > 1 { 30.0 } else { 8.0 };
                refused += 1;
                if refused > 8 || lambda > 1e10 {
                    break;
                }
            }
        }
    }
    let costs = [FIT_ROWS, CHOOSE_ROWS, SCORE_ROWS].map(|only| now.cost(only));
    Some(Fitted { model, states, costs, rows: now.rows })
}
