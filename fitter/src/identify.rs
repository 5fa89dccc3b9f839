//! Identification (Eq. 11): the least-squares solution for a given order, by Householder QR in the
//! orthonormal basis, refined to the exact minimiser and then written in powers of the reading.
//!
//! The refinement (Björck 1967: residual and right-hand side in doubled precision) leaves the least-squares
//! solution rounded once, so that it does not depend on the instruction set that the factorisation ran on.

use nalgebra::DMatrix;

use crate::basis::Basis;
use crate::double_double::Double;
use crate::fit::FitError;

/// Rows of a least-squares problem: weight·(error − Σ cₖ gain pₖ)² is summed.
pub(crate) struct Problem<'a> {
    pub basis: &'a Basis,
    pub order: usize,
    pub reading: &'a [f64],
    pub gain: &'a (dyn Fn(f64) -> f64 + Sync),
    pub error: &'a [f64],
    pub weight: &'a (dyn Fn(usize) -> f64 + Sync),
}

/// Rows of one block of the factorisation.
const BLOCK: usize = 8192;
/// Above so many rows the refinement is left out: its effect is far below the rounding of the printed
/// recording, and it would take longer than the rest.
const REFINED_ROWS: usize = 2_000_000;

impl Problem<'_> {
    /// gain·p₀ … gain·pₙ of row `row`.
    pub fn model_row(&self, row: usize, values: &mut [f64]) {
        self.basis.evaluate(self.reading[row], values);
        let gain = (self.gain)(self.reading[row]);
        values.iter_mut().for_each(|p| *p *= gain);
    }

    /// The triangular factor of the weighted rows with the error as their last column, block by block: each
    /// block's rows are stacked under the factor of those before.
    fn triangle(&self) -> DMatrix<f64> {
        let columns = self.order + 2;
        let mut factor: DMatrix<f64> = DMatrix::zeros(0, columns);
        let mut values = vec![0.0; self.order + 1];
        for start in (0..self.reading.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(self.reading.len());
            let above = factor.nrows();
            let mut stacked = DMatrix::zeros(above + end - start, columns);
            stacked.rows_mut(0, above).copy_from(&factor);
            for row in start..end {
                let root = (self.weight)(row).sqrt();
                self.model_row(row, &mut values);
                for (column, value) in values.iter().enumerate() {
                    stacked[(above + row - start, column)] = root * value;
                }
                stacked[(above + row - start, columns - 1)] = root * self.error[row];
            }
            factor = stacked.qr().unpack_r();
        }
        factor
    }

    /// Coefficients of the basis that minimise the weighted squares; none if the rows do not determine them.
    pub fn solve_qr(&self) -> Option<Vec<Double>> {
        let parameters = self.order + 1;
        let triangle = self.triangle();
        if triangle.nrows() < parameters {
            return None;
        }
        let r = triangle.view((0, 0), (parameters, parameters));
        let largest = (0..parameters).map(|i| r[(i, i)].abs()).fold(0.0, f64::max);
        if (0..parameters).any(|i| r[(i, i)].abs() <= 1e-10 * largest) {
            return None;
        }
        let solution = r.solve_upper_triangular(&triangle.view((0, parameters), (parameters, 1)))?;
        let mut c: Vec<Double> = solution.iter().map(|c| Double::from(*c)).collect();
        if self.reading.len() <= REFINED_ROWS {
            for _ in 0..4 {
                let gradient = self.gradient(&c).into_iter().map(Double::round);
                let step = r.tr_solve_upper_triangular(&DMatrix::from_iterator(parameters, 1, gradient))?;
                let step = r.solve_upper_triangular(&step)?;
                for (c, step) in c.iter_mut().zip(step.iter()) {
                    *c = *c + Double::from(*step);
                }
            }
        }
        Some(c)
    }

    /// Aᵀ W (error − A c) in doubled precision; it vanishes at the minimiser.
    fn gradient(&self, c: &[Double]) -> Vec<Double> {
        let mut sums = vec![Double::ZERO; c.len()];
        let mut values = vec![0.0; c.len()];
        for row in 0..self.reading.len() {
            self.model_row(row, &mut values);
            let mut residual = Double::from(self.error[row]);
            for (c, value) in c.iter().zip(&values) {
                residual = residual - *c * *value;
            }
            let residual = residual * (self.weight)(row);
            for (sum, value) in sums.iter_mut().zip(&values) {
                *sum = *sum + residual * *value;
            }
        }
        sums
    }
}

/// The direction in (Δd, a₀ … aₙ) that no recording determines.
pub(crate) struct NullDirection {
    /// Change of Δd (first) and of a₀ … aₙ, scaled so that Δd changes by 1 mm.
    pub direction: Vec<f64>,
    /// Smallest singular value over the largest.
    pub singular_value: f64,
}

/// Finds the null direction of Eq. 6 in all its parameters (Δd, a₀ … aₙ) by the singular value
/// decomposition of its Jacobian at the given readings, columns scaled to length 1.
///
/// # Errors
/// [`FitError::Singular`] if the decomposition does not converge.
pub(crate) fn null_direction(
    readings: &[f64],
    distance_mm: f64,
    order: usize,
) -> Result<NullDirection, FitError> {
    let columns = order + 2;
    let gain = |s: f64| distance_mm / (s * s + distance_mm * distance_mm);
    let mut jacobian = DMatrix::from_fn(readings.len(), columns, |row, column| {
        let s = readings[row];
        match column {
            0 => -gain(s) * s / distance_mm,
            _ => gain(s) * s.powi(column as i32 - 1),
        }
    });
    let mut lengths = vec![0.0; columns];
    for (column, length) in lengths.iter_mut().enumerate() {
        *length = (0..readings.len()).map(|row| jacobian[(row, column)].powi(2)).sum::<f64>().sqrt();
        (0..readings.len()).for_each(|row| jacobian[(row, column)] /= *length);
    }
    // The decomposition sorts its values, the largest first.
    let svd = jacobian.try_svd(false, true, f64::EPSILON, 0).ok_or(FitError::Singular)?;
    let right = svd.v_t.ok_or(FitError::Singular)?;
    let values = svd.singular_values;
    let last = values.len() - 1;
    let vector: Vec<f64> = right.row(last).iter().zip(&lengths).map(|(v, length)| v / length).collect();
    let scale = vector[0];
    Ok(NullDirection {
        direction: vector.iter().map(|value| value / scale).collect(),
        singular_value: values[last] / values[0],
    })
}
