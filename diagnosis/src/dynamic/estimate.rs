//! Output error: the parameters and initial states whose free-run simulation is nearest to the recording,
//! by Levenberg's and Marquardt's method (Marquardt 1963) on exact sensitivities. An unstable simulation is
//! a step that is refused.

use fitter::plant::Hold;
use numerics::parallel;

use super::data::{ALL, CHOOSE_ROWS, Data, FIT_ROWS, FOLDS, Folds, SCORE_ROWS, over};
use super::gram::Grams;
use super::model::Model;
use super::simulate::Unstable;
use crate::thresholds::dynamic::estimate::{ENOUGH, PATIENCE};
use crate::thresholds::dynamic::gram::MOST_FREE;

/// A model that is simulated in free run and estimated by its output error.
pub trait Simulated: Clone + Send + Sync {
    /// The state at the start of a run.
    type Start: Clone + Send + Sync;

    /// The free parameters as an estimate sees them.
    fn packed(&self) -> Vec<f64>;

    /// The model with its free parameters set.
    #[must_use]
    fn unpacked(&self, packed: &[f64]) -> Self;

    /// A start, moved.
    fn moved(&self, start: &Self::Start, by: &[f64]) -> Self::Start;

    /// The normal equations of a simulation through several filters: `filters` are the coefficients c of
    /// e_t = x_t − Σ c_j x_(t−j), which residual and sensitivities pass first (empty: none).
    ///
    /// # Errors
    /// [`Unstable`].
    fn normals<const F: usize>(
        &self,
        starts: &[Self::Start],
        data: &Data,
        filters: [&[f64]; F],
    ) -> Result<[Grams; F], Unstable>;

    /// The same through one filter.
    ///
    /// # Errors
    /// [`Unstable`].
    fn normal(&self, starts: &[Self::Start], data: &Data, whitening: &[f64]) -> Result<Grams, Unstable> {
        let [one] = self.normals(starts, data, [whitening])?;
        Ok(one)
    }

    /// The simulated positions of all runs, row for row of the recording; NaN in rows of no run.
    ///
    /// # Errors
    /// [`Unstable`].
    fn positions(&self, starts: &[Self::Start], data: &Data) -> Result<Vec<f64>, Unstable>;
}

/// A model with what belongs to this recording, and how well it does.
#[derive(Clone)]
pub struct Fitted<M: Simulated = Model> {
    pub model: M,
    /// The state at the start of every run.
    pub states: Vec<M::Start>,
    /// Sum of squared residuals of every kind of row.
    pub costs: [f64; FOLDS],
    /// Rows of every kind.
    pub rows: [usize; FOLDS],
}

impl<M: Simulated> Fitted<M> {
    /// Sum of squared residuals of the wanted kinds of rows.
    pub fn cost(&self, folds: Folds) -> f64 {
        over(folds, &self.costs)
    }

    /// Root mean square of the residual of the wanted kinds of rows.
    pub fn rms(&self, folds: Folds) -> f64 {
        (self.cost(folds) / over(folds, &self.rows).max(1) as f64).sqrt()
    }

    /// The part of the motion that it leaves: squared residuals over squares of the recorded position about its mean.
    pub fn part_left(&self, data: &Data) -> f64 {
        let rows = data.runs.iter().flat_map(|run| &data.position[run.clone()]);
        let motion = numerics::centred(&rows.copied().collect::<Vec<f64>>());
        self.cost(ALL) / motion.iter().map(|y| y * y).sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// The simulated positions of all runs, row for row of the recording; NaN in rows of no run.
    ///
    /// # Errors
    /// [`Unstable`].
    pub fn positions(&self, data: &Data) -> Result<Vec<f64>, Unstable> {
        self.model.positions(&self.states, data)
    }

    /// What it leaves of the recorded positions; none where its simulation is unstable.
    pub fn residual(&self, data: &Data) -> Option<Vec<f64>> {
        let positions = self.positions(data).ok()?;
        Some(data.position.iter().zip(&positions).map(|(a, b)| a - b).collect())
    }
}

/// Fits a model to the wanted kinds of rows; none where it cannot be simulated at all.
pub fn fit<M: Simulated>(model: &M, states: &[M::Start], data: &Data, folds: Folds) -> Option<Fitted<M>> {
    fit_in(PATIENCE, model, states, data, folds)
}

/// The same for each assumption about how the drive runs between the samples; those that cannot be simulated are left out.
pub fn fit_with_each_hold(
    holds: impl IntoIterator<Item = Hold>,
    model: &Model,
    states: &[[f64; 2]],
    data: &Data,
    folds: Folds,
) -> Vec<Fitted> {
    let one = |hold: &Hold| fit(&Model { hold: *hold, ..model.clone() }, states, data, folds);
    parallel::filter_map(&Vec::from_iter(holds), one)
}

/// The same in so many steps at most.
pub fn fit_in<M: Simulated>(
    patience: usize,
    model: &M,
    states: &[M::Start],
    data: &Data,
    folds: Folds,
) -> Option<Fitted<M>> {
    if model.packed().len() > MOST_FREE {
        return None;
    }
    let mut model = model.clone();
    let mut states = states.to_vec();
    let mut now = model.normal(&states, data, &[]).ok()?;
    // What has lost its influence is damped as when it had most (J. J. Moré, Lecture Notes in Mathematics 630, 1978).
    let mut scales = now.scales(folds);
    let mut lambda = 1e-3;
    let mut refused = 0;
    for _ in 0..patience {
        let cost = now.cost(folds);
        let (step, moves, promised) = now.step(folds, lambda, &scales);
        if promised.is_nan() || promised <= ENOUGH * cost / now.rows(folds).max(1) as f64 {
            break;
        }
        let packed: Vec<f64> = model.packed().iter().zip(&step).map(|(x, d)| x + d).collect();
        let there = model.unpacked(&packed);
        let moved: Vec<M::Start> = states.iter().zip(&moves).map(|(s, d)| model.moved(s, d)).collect();
        match there.normal(&moved, data, &[]) {
            Ok(next) if next.cost(folds) < cost => {
                let got = cost - next.cost(folds);
                (model, states, now) = (there, moved, next);
                scales.iter_mut().zip(now.scales(folds)).for_each(|(scale, new)| *scale = scale.max(new));
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
