//! The smooth part of a channel: polynomials of the angle, of the time, and of the angle by direction, fitted so that
//! single rows far out hardly count.

use nalgebra::{DMatrix, DVector};

use super::limits;
use super::scale::{median, range, scaled, trimmed};

/// Deviations beyond so many times the scatter count as if they were no larger (Huber).
const LINEAR: f64 = 2.0;
const ITERATIONS: usize = 6;

/// Columns of the base, orthogonal polynomials over the given rows.
pub struct Base {
    columns: DMatrix<f64>,
}

impl Base {
    pub fn new(angle: &[f64], time: &[f64], direction: &[f64]) -> Base {
        let n = angle.len();
        let mut sorted = angle.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let (low, high) = range(angle);
        let near = 1e-3 * (high - low);
        let positions = 1 + sorted.windows(2).filter(|pair| pair[1] - pair[0] > near).count();
        let order = limits::BASE_ORDER.min(2 * positions / 5).min(n / limits::ROWS_PER_TERM);
        let over_time = limits::TIME_ORDER.min(n / 40);
        let both = direction.iter().any(|d| *d != direction[0]) && n >= 60 && positions >= 6;
        let or_middle =
            |x: Vec<f64>| -> Vec<f64> { x.iter().map(|x| if x.is_finite() { *x } else { 0.0 }).collect() };
        let (a, t) = (or_middle(scaled(angle)), or_middle(scaled(time)));
        let count = order + 1 + over_time + if both { 3 } else { 0 };
        // Column after column, as the matrix has them.
        let mut columns = Vec::with_capacity(n * count);
        (0..=order).for_each(|k| columns.extend(chebyshev(&a, k)));
        (1..=over_time).for_each(|k| columns.extend(chebyshev(&t, k)));
        if both {
            let by_direction = |k| chebyshev(&a, k).into_iter().zip(direction).map(|(p, d)| p * d);
            (0..=2).for_each(|k| columns.extend(by_direction(k)));
        }
        Base { columns: DMatrix::from_vec(n, count, columns) }
    }

    /// The channel less its smooth part; blanks stay blank.
    pub fn residual(&self, values: &[f64]) -> Vec<f64> {
        let smooth = cleaned(values);
        let mut weight: Vec<f64> = values.iter().map(|v| if v.is_finite() { 1.0 } else { 0.0 }).collect();
        let mut residual = smooth.clone();
        for _ in 0..ITERATIONS {
            let Some(fitted) = self.fit(&smooth, &weight) else { break };
            residual = smooth.iter().zip(fitted.iter()).map(|(v, f)| v - f).collect();
            let mut absolute: Vec<f64> = residual.iter().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
            let limit = LINEAR * trimmed(&mut absolute);
            for (weight, r) in weight.iter_mut().zip(&residual) {
                *weight =
                    if !r.is_finite() { 0.0 } else { limit / r.abs().max(limit).max(f64::MIN_POSITIVE) };
            }
        }
        (values.iter().zip(&smooth).zip(residual)).map(|((v, s), r)| r + (v - s)).collect()
    }

    fn fit(&self, values: &[f64], weight: &[f64]) -> Option<DVector<f64>> {
        let (n, terms) = self.columns.shape();
        let mut normal = DMatrix::zeros(terms, terms);
        let mut right = DVector::zeros(terms);
        for row in 0..n {
            if weight[row] == 0.0 {
                continue;
            }
            for i in 0..terms {
                let x = weight[row] * self.columns[(row, i)];
                right[i] += x * values[row];
                for j in 0..=i {
                    normal[(i, j)] += x * self.columns[(row, j)];
                }
            }
        }
        for i in 0..terms {
            for j in 0..i {
                normal[(j, i)] = normal[(i, j)];
            }
            // Angle and time are one in a single move: a little on the diagonal decides between them.
            normal[(i, i)] += 1e-9 * n as f64;
        }
        let coefficients = normal.cholesky()?.solve(&right);
        Some(&self.columns * coefficients)
    }
}

fn chebyshev(x: &[f64], order: usize) -> Vec<f64> {
    x.iter().map(|x| (order as f64 * x.clamp(-1.0, 1.0).acos()).cos()).collect()
}

/// Rows before and after, with whose median a row far out is replaced before the first fit.
const BEFORE_AND_AFTER: usize = 3;
/// Multiples of the scatter of the differences to that median from which on it is.
const REPLACED: f64 = 6.0;

fn cleaned(values: &[f64]) -> Vec<f64> {
    let local: Vec<f64> = (0..values.len())
        .map(|row| {
            let range = row.saturating_sub(BEFORE_AND_AFTER)..(row + BEFORE_AND_AFTER + 1).min(values.len());
            let mut near: Vec<f64> =
                range.filter(|other| *other != row).map(|k| values[k]).filter(|v| v.is_finite()).collect();
            median(&mut near)
        })
        .collect();
    let away = |(v, m): (&f64, &f64)| (v - m).abs();
    let mut absolute: Vec<f64> = values.iter().zip(&local).map(away).filter(|d| d.is_finite()).collect();
    let limit = REPLACED * trimmed(&mut absolute);
    values.iter().zip(&local).map(|(v, m)| if (v - m).abs() > limit { *m } else { *v }).collect()
}
