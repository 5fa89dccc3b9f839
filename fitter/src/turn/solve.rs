//! Least squares in columns that are given row by row: sums of products, their factor, and steps of refinement.

use crate::gram::{Factor, Grams};

/// Writes the columns of a row.
type Fill<'a> = dyn Fn(usize, &mut [f64]) + 'a;

/// The columns of a problem: `fill(row, values)` writes them.
pub(super) struct Columns<'a> {
    pub count: usize,
    pub rows: usize,
    pub fill: Box<Fill<'a>>,
}

/// A solution with what its covariance needs.
pub(super) struct Solution {
    pub c: Vec<f64>,
    pub factor: Factor,
    /// What the columns leave of the errors.
    pub residual: Vec<f64>,
    /// Its sum of squares.
    pub squares: f64,
}

impl Columns<'_> {
    /// The sums of all rows, the errors being the last column, by fold and point.
    pub fn grams(
        &self,
        folds: usize,
        points: usize,
        error: &[f64],
        cell: &dyn Fn(usize) -> (usize, usize),
    ) -> Grams {
        Grams::accumulate(self.count - 1, folds, points, 0..self.rows, |row, values| {
            (self.fill)(row, &mut values[..self.count]);
            values[self.count] = error[row];
            cell(row)
        })
    }

    /// The coefficients that minimise the squares of what is left of the errors; none if the rows do not
    /// determine them.
    pub fn solve(&self, error: &[f64]) -> Option<Solution> {
        let mut c = vec![0.0; self.count];
        let mut residual = error.to_vec();
        // The second pass takes off what the rounding of the sums left in the first.
        for _ in 0..2 {
            let factor = self.grams(1, 1, &residual, &|_| (0, 0)).total(|_, _| 1.0).factor();
            if factor.order != Some(self.count - 1) {
                return None;
            }
            c.iter_mut().zip(factor.solve(self.count - 1)).for_each(|(c, step)| *c += step);
            residual = self.without(&c, error);
        }
        let factor = self.grams(1, 1, &residual, &|_| (0, 0)).total(|_, _| 1.0).factor();
        let squares = residual.iter().map(|r| r * r).sum();
        Some(Solution { c, factor, residual, squares })
    }

    /// The columns but one, and that one.
    pub fn without_column(&self, column: usize) -> (Columns<'_>, Vec<f64>) {
        let every = |row: usize| {
            let mut values = vec![0.0; self.count];
            (self.fill)(row, &mut values);
            values
        };
        let taken = (0..self.rows).map(|row| every(row)[column]).collect();
        let fill = move |row: usize, values: &mut [f64]| {
            let mut all = every(row);
            all.remove(column);
            values.copy_from_slice(&all);
        };
        (Columns { count: self.count - 1, rows: self.rows, fill: Box::new(fill) }, taken)
    }

    fn without(&self, c: &[f64], error: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.count];
        (0..self.rows)
            .map(|row| {
                (self.fill)(row, &mut values);
                error[row] - values.iter().zip(c).map(|(v, c)| v * c).sum::<f64>()
            })
            .collect()
    }
}
