//! Sums of products of the model's rows, kept apart by calibration point and by fold of passes: from them
//! every split of the order selection is solved without touching the rows again.
//!
//! A row is (gain·p₀, …, gain·p_N, error); the sums of its products are a packed upper triangle, small
//! and well conditioned, because the basis is orthonormal over the recording.

use crate::basis::Basis;

/// Number of columns of a model row: order + 1 polynomials and the error.
pub(crate) fn columns(order: usize) -> usize {
    order + 2
}

/// Where (i, j), i ≤ j, lies in a packed upper triangle.
pub(crate) fn at(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

/// Length of a packed upper triangle.
pub(crate) fn packed(columns: usize) -> usize {
    columns * (columns + 1) / 2
}

/// Sums of products per (fold of passes, point).
pub(crate) struct Grams {
    /// Highest order in the rows.
    pub order: usize,
    pub folds: usize,
    pub points: usize,
    sums: Vec<f64>,
    rows: Vec<usize>,
}

/// One row of the problem.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    pub reading: f64,
    pub gain: f64,
    /// Angular error Δθ_M (Eq. 8) in the internal unit.
    pub error: f64,
    pub fold: usize,
    pub point: usize,
}

impl Grams {
    /// The sums of the rows of a polynomial problem.
    pub fn of(basis: &Basis, folds: usize, points: usize, rows: impl Iterator<Item = Row>) -> Grams {
        let order = basis.order();
        Grams::accumulate(order, folds, points, rows, |row, values| {
            basis.evaluate(row.reading, &mut values[..=order]);
            values[..=order].iter_mut().for_each(|p| *p *= row.gain);
            values[order + 1] = row.error;
            (row.fold, row.point)
        })
    }

    /// Accumulates rows in the given order, one after the other, so that the sums do not depend on how many
    /// threads there are. `fill` writes a row's order + 1 columns and its error, and says which fold and point
    /// the row belongs to.
    pub fn accumulate<T>(
        order: usize,
        folds: usize,
        points: usize,
        rows: impl Iterator<Item = T>,
        mut fill: impl FnMut(T, &mut [f64]) -> (usize, usize),
    ) -> Grams {
        let (width, size) = (columns(order), packed(columns(order)));
        let mut grams = Grams {
            order,
            folds,
            points,
            sums: vec![0.0; size * folds * points],
            rows: vec![0; folds * points],
        };
        let mut values = vec![0.0; width];
        for row in rows {
            let (fold, point) = fill(row, &mut values);
            let cell = fold * points + point;
            grams.rows[cell] += 1;
            add_products(&mut grams.sums[cell * size..][..size], &values);
        }
        grams
    }

    /// Sum over folds and points of factor(fold, point) times the cell's sums.
    pub fn total(&self, factor: impl Fn(usize, usize) -> f64) -> Sums {
        let mut total = Sums::zero(self.order);
        for fold in 0..self.folds {
            for point in 0..self.points {
                self.add_cell(&mut total, fold, point, factor(fold, point));
            }
        }
        total
    }

    /// Sum over the folds that are not in `skip` of factor times one point's sums.
    pub fn point(&self, point: usize, factor: f64, skip: &std::ops::Range<usize>) -> Sums {
        let mut total = Sums::zero(self.order);
        for fold in (0..self.folds).filter(|fold| !skip.contains(fold)) {
            self.add_cell(&mut total, fold, point, factor);
        }
        total
    }

    fn add_cell(&self, total: &mut Sums, fold: usize, point: usize, factor: f64) {
        let (cell, size) = (fold * self.points + point, total.values.len());
        if factor != 0.0 {
            total.rows += self.rows[cell];
            total.weight += factor * self.rows[cell] as f64;
            let sums = &self.sums[cell * size..][..size];
            total.values.iter_mut().zip(sums).for_each(|(total, sum)| *total += factor * sum);
        }
    }
}

fn add_products(sums: &mut [f64], values: &[f64]) {
    let mut rest = sums;
    for (j, right) in values.iter().enumerate() {
        let (column, tail) = rest.split_at_mut(j + 1);
        for (sum, left) in column.iter_mut().zip(values) {
            *sum += left * right;
        }
        rest = tail;
    }
}

/// Sums of products over some rows, as a packed upper triangle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sums {
    pub order: usize,
    pub rows: usize,
    /// Sum of the factors that the rows were counted with.
    pub weight: f64,
    values: Vec<f64>,
}

impl Sums {
    /// Of no rows.
    pub fn zero(order: usize) -> Sums {
        Sums { order, rows: 0, weight: 0.0, values: vec![0.0; packed(columns(order))] }
    }

    /// Adds `factor` times the sums of other rows; with a factor of −1, rows that were added before are
    /// taken out again.
    pub fn add(&mut self, other: &Sums, factor: f64) {
        self.rows = if factor < 0.0 { self.rows - other.rows } else { self.rows + other.rows };
        self.weight += factor * other.weight;
        self.values.iter_mut().zip(&other.values).for_each(|(to, sum)| *to += factor * sum);
    }

    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.values[at(i.min(j), i.max(j))]
    }

    /// Sum of squares of (error − Σ cₖ gain pₖ) over these rows (the squares of Eq. 9 and 10), c being the
    /// coefficients of p₀ … .
    pub fn squares(&self, c: &[f64]) -> f64 {
        let error = self.order + 1;
        let mut sum = self.get(error, error);
        for (j, cj) in c.iter().enumerate() {
            let mut column = -2.0 * self.get(j, error) + cj * self.get(j, j);
            for (i, ci) in c[..j].iter().enumerate() {
                column += 2.0 * ci * self.get(i, j);
            }
            sum += cj * column;
        }
        sum.max(0.0)
    }

    /// Cholesky factor L of the sums, as far as they are positive definite: the factor of every lower order
    /// is its leading part, and so is the solution's right-hand side (last row of L).
    pub fn factor(&self) -> Factor {
        let width = columns(self.order);
        let mut l = vec![0.0; packed(width)]; // l[at(i, j)] is L[j][i], i ≤ j
        let mut order = None;
        for j in 0..width {
            for i in 0..j.min(order.map_or(0, |order: usize| order + 1)) {
                let mut sum = self.get(i, j);
                for k in 0..i {
                    sum -= l[at(k, i)] * l[at(k, j)];
                }
                l[at(i, j)] = sum / l[at(i, i)];
            }
            if j < width - 1 && order.is_none_or(|order| order + 1 == j) {
                let left: f64 = self.get(j, j) - (0..j).map(|k| l[at(k, j)] * l[at(k, j)]).sum::<f64>();
                // Columns have length of about 1 over all rows; below, the split does not determine this order.
                if left > 1e-9 * self.get(j, j).max(1e-3) {
                    l[at(j, j)] = left.sqrt();
                    order = Some(j);
                }
            }
        }
        Factor { error: self.order + 1, order, l }
    }
}

/// See [`Sums::factor`].
pub(crate) struct Factor {
    error: usize,
    /// The highest order that is determined; none if there is no row.
    pub order: Option<usize>,
    l: Vec<f64>,
}

impl Factor {
    /// Coefficients of p₀ … p_order that minimise the squares.
    pub fn solve(&self, order: usize) -> Vec<f64> {
        let mut c = vec![0.0; order + 1];
        for i in (0..=order).rev() {
            let mut sum = self.l[at(i, self.error)];
            for (j, cj) in c.iter().enumerate().skip(i + 1) {
                sum -= self.l[at(i, j)] * cj;
            }
            c[i] = sum / self.l[at(i, i)];
        }
        c
    }

    /// Inverse of the sums of p₀ … p_order: the covariance of the coefficients for unit noise, row by row.
    pub fn inverse(&self, order: usize) -> Vec<Vec<f64>> {
        let n = order + 1;
        // Columns of L⁻¹ by forward substitution, then L⁻ᵀ L⁻¹.
        let inverse: Vec<Vec<f64>> = (0..n)
            .map(|unit| {
                let mut column = vec![0.0; n];
                for i in unit..n {
                    let known: f64 = (unit..i).map(|k| self.l[at(k, i)] * column[k]).sum();
                    let right = if i == unit { 1.0 } else { 0.0 };
                    column[i] = (right - known) / self.l[at(i, i)];
                }
                column
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
        inverse.iter().map(|a| inverse.iter().map(|b| dot(a, b)).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The solution from sums is that of the rows: the squares are smallest there, and their value agrees.
    #[test]
    fn solves_every_order_from_one_factor() {
        let x: Vec<f64> = (0..30).map(|i| -1.0 + i as f64 / 14.5).collect();
        let y: Vec<f64> = x.iter().map(|x| (3.0 * x).sin()).collect();
        let basis = Basis::new(&x, &[1.0; 30], 8);
        let rows =
            x.iter().zip(&y).map(|(x, y)| Row { reading: *x, gain: 1.0, error: *y, fold: 0, point: 0 });
        let sums = Grams::of(&basis, 1, 1, rows).total(|_, _| 1.0);
        let factor = sums.factor();
        assert_eq!(factor.order, Some(8));
        for order in 0..=8 {
            let c = factor.solve(order);
            let mut p = vec![0.0; order + 1];
            let direct: f64 = (x.iter().zip(&y))
                .map(|(x, y)| {
                    basis.evaluate(*x, &mut p);
                    (y - p.iter().zip(&c).map(|(p, c)| p * c).sum::<f64>()).powi(2)
                })
                .sum();
            approx::assert_abs_diff_eq!(sums.squares(&c), direct, epsilon = 1e-12);
            for k in 0..=order {
                let mut moved = c.clone();
                moved[k] += 1e-3;
                assert!(sums.squares(&moved) > sums.squares(&c));
            }
        }
    }
}
