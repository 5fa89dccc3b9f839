//! Every row at which a step may begin, judged at once. A step from row k on is the sum of the single rows from
//! there, so that its product with any v in the whitened metric is a sum over the tail of Wᵀ v: one pass over the
//! rows serves all k. No grid would do, since in correlated noise a step is told by the one reading at which
//! it begins, and a step two rows off explains next to nothing.

use numerics::Basis;

use crate::correlation::Whitener;

/// Steps beside a whitened basis.
#[derive(Debug, Clone)]
pub struct Jumps {
    whitener: Whitener,
    /// 1/length of every row's whitened step outside the basis; 0 where none may begin.
    inverse: Vec<f64>,
}

impl Jumps {
    /// Steps that begin at one of `rows`; left out where less than `smallest` of the length is outside the basis.
    pub fn beside(whitener: &Whitener, basis: &Basis, rows: std::ops::Range<usize>, smallest: f64) -> Jumps {
        let whole = whitener.squared_lengths_of_steps();
        let mut inside = vec![0.0; whole.len()];
        for k in 0..basis.rank() {
            let products = sums_from_the_end(whitener.transposed(basis.columns.get(k)));
            inside.iter_mut().zip(products).for_each(|(sum, p)| *sum += p * p);
        }
        let inverse = |(k, (whole, inside)): (usize, (&f64, f64))| {
            let left = whole - inside;
            let enough = rows.contains(&k) && left > smallest * smallest * whole;
            if enough { 1.0 / left.sqrt() } else { 0.0 }
        };
        let inverse = whole.iter().zip(inside).enumerate().map(inverse).collect();
        Jumps { whitener: whitener.clone(), inverse }
    }

    /// The score of the step from every row on in a whitened residual that lies outside the basis: its square is
    /// what the step explains.
    pub fn scores(&self, residual: &[f64]) -> Vec<f64> {
        let products = sums_from_the_end(self.whitener.transposed(residual));
        products.iter().zip(&self.inverse).map(|(p, inverse)| p * inverse).collect()
    }

    /// The row from which a step explains most, and how much; of equals the first.
    pub fn best(&self, residual: &[f64]) -> Option<(usize, f64)> {
        let squares = self.scores(residual).into_iter().map(|s| s * s).enumerate();
        squares.rev().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|best| best.1 > 0.0)
    }
}

/// A step from `row` on, among `n` rows.
pub fn step(n: usize, row: usize) -> Vec<f64> {
    (0..n).map(|i| if i >= row { 1.0 } else { 0.0 }).collect()
}

fn sums_from_the_end(mut values: Vec<f64>) -> Vec<f64> {
    let mut sum = 0.0;
    for v in values.iter_mut().rev() {
        sum += *v;
        *v = sum;
    }
    values
}

#[cfg(test)]
mod tests {
    use super::{Jumps, step};
    use crate::correlation::{Correlation, Process};
    use numerics::{Basis, dot};

    #[test]
    fn all_rows_at_once_are_each_row_by_itself() {
        let n = 90;
        let value = |i: usize, k: usize| ((i * i * (k + 3) + 7 * i * k) as f64 * 0.618).sin();
        let t: Vec<f64> = (0..n).map(|i| i as f64 + if i < 30 { 0.0 } else { 40.0 }).collect();
        let sigma: Vec<f64> = (0..n).map(|i| 1.0 + 0.3 * value(i, 9)).collect();
        let lasting = Process { new: 0.2, parts: vec![(0.5, 6.0), (0.3, 90.0)] };
        for process in [Process::white(), Process::slow(1.0, 6.0), lasting] {
            let whitener = Correlation::none(&t).with(&process).whitener(&sigma);
            let mut basis = Basis::new(n);
            basis.add(&whitener.whiten(&vec![1.0; n]));
            basis.add(&whitener.whiten(&step(n, 50)));
            let mut residual: Vec<f64> = (0..n).map(|i| value(i, 5)).collect();
            basis.project_off(&mut residual);
            let scores = Jumps::beside(&whitener, &basis, 2..n - 1, 0.02).scores(&residual);
            for (k, score) in scores.iter().enumerate() {
                let mut alone = whitener.whiten(&step(n, k));
                basis.project_off(&mut alone);
                let length = dot(&alone, &alone).sqrt();
                let wanted =
                    if (2..n - 1).contains(&k) && k != 50 { dot(&alone, &residual) / length } else { 0.0 };
                assert!((score - wanted).abs() < 1e-9, "{k}: {score} for {wanted}");
            }
        }
    }
}
