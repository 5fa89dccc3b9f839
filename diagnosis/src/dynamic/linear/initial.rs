//! The state at the first row of a stretch that is not in steady state, from its first rows.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::looped::Looped;
use super::modal::Modal;
use crate::thresholds::dynamic::linear::initial::RIDGE;

/// x₀ by least squares on the first `rows` rows of `drive` and `position` (by rows); at rest where there are
/// none.
pub fn state(model: &Modal, drive: &[f64], position: &[f64], rows: usize) -> Vec<f64> {
    let (n, m, p) = (model.order(), model.inputs, model.outputs);
    let rows = rows.min(drive.len() / m.max(1));
    let at_rest = vec![0.0; n];
    if rows == 0 || n == 0 {
        return at_rest;
    }
    let looped = Looped::plain(model.clone());
    let Some(forced) = looped.simulate(&drive[..rows * m], &mut looped.rest()) else { return at_rest };
    // C Aᵏ for every row, from the transposed recursion on C.
    let mut design = Mat::<f64>::zeros(rows * p, n);
    let mut c = model.c.clone();
    for row in 0..rows {
        for i in 0..p {
            for s in 0..n {
                design[(row * p + i, s)] = c[i * n + s];
            }
        }
        model.times_a(&mut c);
    }
    let target = Mat::from_fn(rows * p, 1, |i, _| position[i] - forced[i]);
    let mut gram = design.transpose() * &design;
    let ridge = RIDGE * (0..n).map(|i| gram[(i, i)]).sum::<f64>() / n as f64;
    for i in 0..n {
        gram[(i, i)] += ridge.max(f64::MIN_POSITIVE);
    }
    match gram.llt(Side::Lower) {
        Ok(factor) => {
            let x = factor.solve(design.transpose() * target);
            (0..n).map(|i| x[(i, 0)]).collect()
        }
        Err(_) => at_rest,
    }
}
