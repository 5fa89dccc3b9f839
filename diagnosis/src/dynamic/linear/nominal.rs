//! The linear nominal: as many states as held-out rows pay for.

use super::modal::Modal;
use super::refine::refine;
use super::subspace::{Subspace, subspace};
use crate::dynamic::spectrum::frf::Line;
use crate::dynamic::spectrum::{Complex, Experiments};
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

/// Part of the position's power that no linear model of any order explains: what the frequency response of the
/// experiments themselves leaves; none of it where they are too few to leave anything.
fn unexplained(data: &Experiments) -> f64 {
    if data.each.len() <= data.inputs {
        return 0.0;
    }
    let (mut left, mut all) = (0.0, 0.0);
    for line in 0..data.lines.len() {
        let own = Line::of(data, line).map_or_else(Vec::new, |line| line.gain);
        // A line on which the drives do not span all inputs has no response: nothing of it is called unexplained.
        let any = own.iter().any(|gain| *gain != Complex::ZERO);
        let gain = if any { own } else { vec![Complex::ZERO; data.inputs * data.outputs] };
        for (rest, power) in data.left(line, &gain) {
            left += if any { rest } else { 0.0 };
            all += power;
        }
    }
    left / all.max(f64::MIN_POSITIVE)
}

/// The smallest even order that is nearly as close to the frequency response of the experiments as the closest of all
/// orders: of those held out, where they have a response of their own or the others leave nothing of theirs. What is left
/// of that response itself, noise and what changes with the amplitude, says nothing of the order: it would hide the weaker
/// modes, the more amplitudes there are the more of them.
pub fn choose_order(data: &Experiments, held: Option<&Experiments>) -> Option<usize> {
    let space = range(data)?;
    let enough = |e: &Experiments| e.each.len() > e.inputs;
    let on = held.filter(|held| enough(held) || !enough(data)).unwrap_or(data);
    let unexplained = unexplained(on);
    let scored: Vec<(usize, f64)> = (1..=MOST / 2)
        .map(|k| 2 * k)
        .filter(|order| *order <= space.most())
        .filter_map(|order| Some((order, error(&space.model(order)?, on).powi(2) - unexplained)))
        .filter(|(_, apart)| apart.is_finite())
        .collect();
    let least = scored.iter().map(|s| s.1).fold(f64::INFINITY, f64::min).max(0.0);
    scored.iter().find(|s| s.1 <= EXCESS * EXCESS * least).map(|s| s.0)
}

/// The model of `order` states that fits the experiments best.
pub fn identify(data: &Experiments, order: usize) -> Option<Modal> {
    Some(refine(&range(data)?.model(order)?, data, STEPS))
}

fn range(data: &Experiments) -> Option<Subspace> {
    // A segment's leakage and few lines bound the number of block rows that carry anything.
    subspace(data, BLOCK_ROWS.min(data.lines.len() / 3).max(2))
}
