//! Estimates by a simulation whose own error is nothing beside what it leaves of the recording: its steps are as short as the
//! motion asks for. Friction that falls within a row, for one, needs shorter steps than the plant's own motion.

use motion::equations::MOST_SUBSTEPS;

use super::data::{Data, Folds};
use super::estimate::{Fitted, Simulated, fit};
use crate::thresholds::dynamic::accurate::{ACCURATE, BESIDE};

/// A model that can be simulated in shorter steps.
pub trait Refined: Simulated {
    /// How many steps it takes where its own rule for them asks for one.
    fn refinement(&self) -> usize;

    /// The model in so many.
    #[must_use]
    fn refined(&self, steps: usize) -> Self;
}

/// An estimate in steps that its own motion asks for; none where no steps are short enough, or where it cannot be
/// simulated.
pub fn estimated<M: Refined>(model: &M, states: &[M::Start], data: &Data, folds: Folds) -> Option<Fitted<M>> {
    let mut model = accurate(model, states, data)?;
    let mut states = states.to_vec();
    loop {
        let fitted = fit(&model, &states, data, folds)?;
        let asked = accurate(&fitted.model, &fitted.states, data)?.refinement();
        if asked <= model.refinement() {
            return Some(fitted);
        }
        model = fitted.model.refined(asked);
        states = fitted.states;
    }
}

/// The same; where none are short enough, in those that the model has.
pub fn estimated_or_coarse<M: Refined>(
    model: &M,
    states: &[M::Start],
    data: &Data,
    folds: Folds,
) -> Option<Fitted<M>> {
    estimated(model, states, data, folds).or_else(|| fit(model, states, data, folds))
}

/// The model in so many steps that twice as many change nothing beside what it leaves of the recording; none where that
/// are too many, or it cannot be simulated.
pub fn accurate<M: Refined>(model: &M, states: &[M::Start], data: &Data) -> Option<M> {
    let rows = || data.runs.iter().flat_map(|run| run.clone());
    let square = |of: &dyn Fn(usize) -> f64| rows().map(|k| of(k).powi(2)).sum::<f64>();
    let size = square(&|k| data.position[k]);
    let mut model = model.refined(1);
    let mut coarse = model.positions(states, data).ok();
    while model.refinement() < MOST_SUBSTEPS {
        let finer = model.refined(2 * model.refinement());
        let fine = finer.positions(states, data).ok();
        if let (Some(coarse), Some(fine)) = (&coarse, &fine) {
            let left = square(&|k| data.position[k] - fine[k]);
            let apart = square(&|k| coarse[k] - fine[k]);
            if apart <= f64::max(ACCURATE.powi(2) * size, BESIDE.powi(2) * left) {
                return Some(model);
            }
        }
        (model, coarse) = (finer, fine);
    }
    None
}
