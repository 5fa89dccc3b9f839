//! Least squares by orthogonalisation.

use super::orthogonal::{Columns, add_scaled, dot};
use crate::DEPENDENT;

/// Least squares of some values on columns.
pub struct LeastSquares {
    /// Coefficients, one per column.
    pub coefficients: Vec<f64>,
    /// Inverse of XᵀX, by rows.
    pub inverse: Vec<f64>,
    /// Sum of squares of the residual.
    pub rss: f64,
}

/// Solves min ‖y − X c‖ by Gram–Schmidt (stable for the polynomial columns that occur here). Columns that
/// depend on earlier ones get the coefficient 0 and variance 0.
pub fn least_squares(columns: &[Vec<f64>], y: &[f64]) -> LeastSquares {
    let p = columns.len();
    let n = y.len();
    let mut q = Columns::new(n);
    // r[j][k]: component of column k along q_j.
    let mut r = vec![0.0; p * p];
    let mut kept: Vec<Option<usize>> = Vec::with_capacity(p);
    for (k, column) in columns.iter().enumerate() {
        let length = dot(column, column).sqrt();
        let mut w = column.clone();
        for _ in 0..2 {
            for j in 0..q.count() {
                let a = dot(q.get(j), &w);
                r[j * p + k] += a;
                add_scaled(&mut w, -a, q.get(j));
            }
        }
        let left = dot(&w, &w).sqrt();
        if left > DEPENDENT * length && length > 0.0 {
            let j = q.count();
            r[j * p + k] = left;
            w.iter_mut().for_each(|x| *x /= left);
            q.push(&w);
            kept.push(Some(j));
        } else {
            kept.push(None);
        }
    }
    let mut residual = y.to_vec();
    let mut z = Vec::with_capacity(q.count());
    for j in 0..q.count() {
        let a = dot(q.get(j), &residual);
        add_scaled(&mut residual, -a, q.get(j));
        z.push(a);
    }
    let used: Vec<usize> = (0..p).filter(|&k| kept[k].is_some()).collect();
    let m = used.len();
    let factor: Vec<f64> =
        (0..m).flat_map(|j| used.iter().map(move |k| (j, k))).map(|(j, k)| r[j * p + k]).collect();
    let (amplitudes, products) = of_triangle(&factor, &z);
    let mut coefficients = vec![0.0; p];
    let mut inverse = vec![0.0; p * p];
    for a in 0..m {
        coefficients[used[a]] = amplitudes[a];
        for b in 0..m {
            inverse[used[a] * p + used[b]] = products[a * m + b];
        }
    }
    LeastSquares { coefficients, inverse, rss: dot(&residual, &residual) }
}

/// The coefficients of the columns of an upper triangular R (by rows), given those of its orthonormal columns, and the
/// inverse of RᵀR, by rows.
pub fn of_triangle(r: &[f64], orthonormal: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = orthonormal.len();
    let mut inverse = vec![0.0; n * n];
    for k in 0..n {
        inverse[k * n + k] = 1.0 / r[k * n + k];
        for j in (0..k).rev() {
            let sum: f64 = (j + 1..=k).map(|i| r[j * n + i] * inverse[i * n + k]).sum();
            inverse[j * n + k] = -sum / r[j * n + j];
        }
    }
    let coefficients = (0..n).map(|a| (a..n).map(|k| inverse[a * n + k] * orthonormal[k]).sum()).collect();
    let product =
        |a: usize, b: usize| -> f64 { (a.max(b)..n).map(|k| inverse[a * n + k] * inverse[b * n + k]).sum() };
    let products = (0..n * n).map(|i| product(i / n, i % n)).collect();
    (coefficients, products)
}
