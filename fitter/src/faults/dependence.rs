//! Whether a further column of the recording explains readings that stand alone: in a few rows there is more of what the
//! column measures than in all others, and physics that goes with its square shows in those first.

use nalgebra::{Matrix4, Vector4};

use super::limits;
use super::scale::scaled;

/// How deviations go with a column: a parabola of it, and a slope over the angle that goes with it.
pub struct Dependence {
    /// What it says of every row; NaN where the column is blank.
    said: Vec<f64>,
}

impl Dependence {
    /// How the deviations of a channel, in multiples of their scatter, go with a column; none where no more than by chance.
    pub fn of(column: &[f64], angle: &[f64], deviation: &[f64]) -> Option<Dependence> {
        let (z, a) = (scaled(column), scaled(angle));
        let terms = |row: usize| Vector4::new(1.0, z[row], z[row] * z[row], z[row] * a[row]);
        // A row counts no more than an outlier does: alone it is not enough for a dependence.
        let seen = |row: usize| deviation[row].clamp(-limits::OUTLIER, limits::OUTLIER);
        let known = |row: &usize| (z[*row] + a[*row] + deviation[*row]).is_finite();
        let rows: Vec<usize> = (0..deviation.len()).filter(known).collect();
        if rows.len() < limits::FEWEST_ROWS {
            return None;
        }
        let normal: Matrix4<f64> = rows.iter().map(|row| terms(*row) * terms(*row).transpose()).sum();
        let right: Vector4<f64> = rows.iter().map(|row| terms(*row) * seen(*row)).sum();
        let fitted = normal.cholesky()?.solve(&right);
        let mean = right[0] / rows.len() as f64;
        let square = |left: &dyn Fn(usize) -> f64| rows.iter().map(|row| left(*row).powi(2)).sum::<f64>();
        let left = square(&|row| seen(row) - fitted.dot(&terms(row)));
        let gained = square(&|row| seen(row) - mean) - left;
        let significant = gained / 3.0 > limits::OF_A_COLUMN * left / (rows.len() as f64 - 4.0);
        significant.then(|| Dependence { said: (0..z.len()).map(|row| fitted.dot(&terms(row))).collect() })
    }

    /// Whether it explains most of the deviation of a row.
    pub fn explains(&self, row: usize, deviation: f64) -> bool {
        (deviation - self.said[row]).abs() < limits::UNEXPLAINED * deviation.abs()
    }
}
