//! Whether a further column of the recording explains a reading that stands alone: in a few rows there is more of what the
//! column measures than in all others, and physics that goes with its square shows in those first.

use nalgebra::{Matrix4, Vector4};

use super::limits;
use super::scale::range;

/// Whether the deviation of a row, in multiples of its scatter, is mostly what the other rows say of the column there: a
/// parabola of it, and a sensitivity that goes with it.
pub fn explains(column: &[f64], angle: &[f64], deviation: &[f64], row: usize) -> bool {
    let (z, a) = (scaled(column), scaled(angle));
    let terms = |k: usize| Vector4::new(1.0, z[k], z[k] * z[k], z[k] * a[k]);
    // Single deviations count no more than an outlier does.
    let seen = |k: usize| deviation[k].clamp(-limits::OUTLIER, limits::OUTLIER);
    let known = |k: &usize| z[*k].is_finite() && a[*k].is_finite() && deviation[*k].is_finite();
    let others: Vec<usize> = (0..deviation.len()).filter(|k| *k != row).filter(known).collect();
    if !known(&row) || others.len() < limits::FEWEST_ROWS {
        return false;
    }
    let normal: Matrix4<f64> = others.iter().map(|k| terms(*k) * terms(*k).transpose()).sum();
    let right: Vector4<f64> = others.iter().map(|k| terms(*k) * seen(*k)).sum();
    let Some(fitted) = normal.cholesky().map(|c| c.solve(&right)) else { return false };
    let mean = right[0] / others.len() as f64;
    let square = |left: &dyn Fn(usize) -> f64| others.iter().map(|k| left(*k).powi(2)).sum::<f64>();
    let left = square(&|k| seen(k) - fitted.dot(&terms(k)));
    let gained = square(&|k| seen(k) - mean) - left;
    let degrees = others.len() as f64 - 4.0;
    let significant = gained / 3.0 > limits::OF_A_COLUMN * left / degrees;
    significant
        && (deviation[row] - fitted.dot(&terms(row))).abs() < limits::UNEXPLAINED * deviation[row].abs()
}

/// The values from −1 to 1 over their range.
fn scaled(values: &[f64]) -> Vec<f64> {
    let (low, high) = range(values);
    let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(f64::MIN_POSITIVE));
    values.iter().map(|value| (value - middle) / half).collect()
}
