//! Output error: the parameters and initial states whose free-run simulation is nearest to the recording,
//! by Levenberg's and Marquardt's method (Marquardt 1963) on exact sensitivities. An unstable simulation is
//! a step that is refused.

use super::data::Data;
use super::gram::{Grams, grams};
use super::model::Model;
use super::simulate::{Theta, Unstable, simulate};
use crate::dynamic::data::FOLDS;
use crate::thresholds::dynamic::estimate::ENOUGH;
use crate::thresholds::dynamic::gram::MOST_FREE;

/// A model with what belongs to this recording, and how well it does.
#[derive(Clone)]
pub struct Fitted {
    /// The model.
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
    pub fn cost(&self, folds: [bool; FOLDS]) -> f64 {
        (0..FOLDS).filter(|f| folds[*f]).map(|f| self.costs[f]).sum()
    }

    /// Root mean square of the residual of the wanted kinds of rows.
    pub fn rms(&self, folds: [bool; FOLDS]) -> f64 {
        let rows: usize = (0..FOLDS).filter(|f| folds[*f]).map(|f| self.rows[f]).sum();
        (self.cost(folds) / rows.max(1) as f64).sqrt()
    }

    /// The simulated positions of all runs, row for row of the recording; NaN in rows of no run.
    ///
    /// # Errors
    /// [`Unstable`].
    pub fn positions(&self, data: &Data) -> Result<Vec<f64>, Unstable> {
        positions(&self.model, &self.states, data)
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
pub fn fit(
    model: &Model,
    states: &[[f64; 2]],
    data: &Data,
    folds: [bool; FOLDS],
    patience: usize,
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
    Some(fitted(model, states, &now))
}

/// A model as it stands, with its figures.
pub fn fitted(model: Model, states: Vec<[f64; 2]>, grams: &Grams) -> Fitted {
    let costs = [0, 1, 2].map(|f| {
        let mut only = [false; FOLDS];
        only[f] = true;
        grams.cost(only)
    });
    Fitted { model, states, costs, rows: grams.rows }
}
