//! The base model's columns (Eq. 6): Legendre polynomials of the scaled reading, times d/(s²+d²) for an
//! eddy-current pair. They span the same models as the powers of Eq. 5 and stay well conditioned. Of a sensor that
//! turns round and round a constant and harmonics of the turn, which wrap as the sensor does; the order is then twice
//! their number.

use std::f64::consts::TAU;

use crate::rows::Rows;

/// Legendre polynomials P₀ … P_order at every x.
pub fn legendre(x: &[f64], order: usize) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = vec![vec![1.0; x.len()]];
    if order > 0 {
        columns.push(x.to_vec());
    }
    for k in 2..=order {
        let kf = k as f64;
        let next = (0..x.len())
            .map(|i| ((2.0 * kf - 1.0) * x[i] * columns[k - 1][i] - (kf - 1.0) * columns[k - 2][i]) / kf)
            .collect();
        columns.push(next);
    }
    columns
}

/// The base model's columns up to `order`, scaled so that a coefficient is about in the error's unit.
pub fn base_columns(rows: &Rows, order: usize) -> Vec<Vec<f64>> {
    if let Some(turn) = rows.whole_turn() {
        return harmonics(&rows.truth, turn, order);
    }
    let scale = 1.0 / numerics::mean(&rows.weight);
    let mut columns = legendre(&rows.scaled_reading(), order);
    for column in &mut columns {
        column.iter_mut().zip(&rows.weight).for_each(|(v, w)| *v *= w * scale);
    }
    columns
}

/// A constant, then cos and sin of each harmonic of the turn at the true position.
fn harmonics(truth: &[f64], turn: f64, order: usize) -> Vec<Vec<f64>> {
    let wave = |k: usize| {
        let phase = truth.iter().map(move |t| TAU * k as f64 * t / turn);
        [phase.clone().map(f64::cos).collect(), phase.map(f64::sin).collect()]
    };
    std::iter::once(vec![1.0; truth.len()]).chain((1..=order / 2).flat_map(wave)).collect()
}
