//! The linear nominal: as many states as held-out rows pay for.

use super::modal::Modal;
use super::refine::refine;
use super::subspace::{Subspace, subspace};
use crate::dynamic::spectrum::Experiments;
use crate::thresholds::dynamic::linear::nominal::{BLOCK_ROWS, EXCESS, MOST, STEPS};

/// Relative error of a model on experiments: rms of the error over rms of the position, over all weighted.
pub fn error(model: &Modal, data: &Experiments) -> f64 {
    let (mut left, mut all) = (0.0, 0.0);
    for (line, &z) in data.points().iter().enumerate() {
        for (rest, power) in data.left(line, &model.response(z)) {
            left += rest;
            all += power;
        }
    }
    (left / all.max(f64::MIN_POSITIVE)).sqrt()
}

/// The smallest even order whose error on `held` (on `data` where nothing is held out) is close to the
/// least of all orders.
pub fn choose_order(data: &Experiments, held: Option<&Experiments>) -> Option<usize> {
    let space = range(data)?;
    let scored: Vec<(usize, f64)> = (1..=MOST / 2)
        .map(|k| 2 * k)
        .filter(|order| *order <= space.most())
        .filter_map(|order| Some((order, error(&space.model(order)?, held.unwrap_or(data)))))
        .filter(|(_, error)| error.is_finite())
        .collect();
    let least = scored.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
    scored.iter().find(|s| s.1 <= EXCESS * least).map(|s| s.0)
}

/// The model of `order` states that fits the experiments best.
pub fn identify(data: &Experiments, order: usize) -> Option<Modal> {
    Some(refine(&range(data)?.model(order)?, data, STEPS))
}

fn range(data: &Experiments) -> Option<Subspace> {
    // A segment's leakage and few lines bound the number of block rows that carry anything.
    subspace(data, BLOCK_ROWS.min(data.lines.len() / 3).max(2))
}
