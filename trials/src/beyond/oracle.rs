//! What can be seen of concealed physics, and what of the error could be corrected by someone who is told it.

use twin::Noise;

use super::lab::Lab;
use crate::linear::{Basis, Whitener, least_squares, norm};

/// The order of the base that is projected off: that of the mirrors' own error, and more than the sensors'.
const ORDER: usize = 9;

/// 1, x, … as Chebyshev polynomials of the reading, over a largest reading.
fn base(lab: &Lab, half: f64) -> Vec<Vec<f64>> {
    let x: Vec<f64> = lab.measured.iter().map(|m| m / half).collect();
    let mut columns = vec![vec![1.0; x.len()], x.clone()];
    for order in 2..=ORDER {
        let next = |row: usize| 2.0 * x[row] * columns[order - 1][row] - columns[order - 2][row];
        let column = (0..x.len()).map(next).collect();
        columns.push(column);
    }
    columns
}

fn half(lab: &Lab) -> f64 {
    lab.measured.iter().fold(0.0, |most, m| m.abs().max(most))
}

/// ρ of what is concealed beside the base; of noise that lasts only its white part counts. None where the base takes
/// nearly all of it.
pub fn rho(lab: &Lab, noise: &Noise) -> Option<f64> {
    let (rows, t_s, square) = (lab.rows(), lab.column("t_s"), lab.noise.powi(2));
    let whitener = match noise {
        Noise::Autocorrelated { .. } => {
            let covariance: Vec<f64> =
                (0..rows * rows).map(|k| square * noise.correlation(t_s[k / rows] - t_s[k % rows])).collect();
            Whitener::new(&covariance, rows)?
        }
        _ => Whitener::Diagonal(vec![lab.noise; rows]),
    };
    let mut basis = Basis::default();
    base(lab, half(lab)).iter().for_each(|column| basis.push(&whitener.whiten(column)));
    let white = whitener.whiten(&lab.effect);
    let left = norm(&basis.residual(&white));
    let about_mean = crate::linear::deviation(&lab.effect) / lab.noise * (rows as f64).sqrt();
    (left > LEFT * about_mean).then_some(left)
}

/// Part of an effect that the base has to leave of it.
const LEFT: f64 = 0.05;

/// What an oracle leaves of a fresh recording: the base and the concealed physics as it is, fitted to the recording by
/// least squares.
pub fn left(seen: &Lab, fresh: &Lab) -> Vec<f64> {
    let half = half(seen);
    let with = |lab: &Lab| {
        let mut columns = base(lab, half);
        columns.push(lab.effect.clone());
        columns
    };
    let amplitudes = least_squares(&with(seen), &seen.error());
    let columns = with(fresh);
    let predicted = |row: usize| -> f64 { columns.iter().zip(&amplitudes).map(|(c, a)| a * c[row]).sum() };
    (0..fresh.rows()).map(|row| fresh.measured[row] - predicted(row) - fresh.clean[row]).collect()
}
