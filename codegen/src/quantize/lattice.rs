//! The polynomials that a format can express, as a lattice with a reduced basis.
//!
//! A polynomial is its Chebyshev coefficients over the range; their products are those of functions with Chebyshev's
//! weight, under which the ends count as much as the middle. The basis is reduced after Lenstra, Lenstra and Lovász, as
//! Brisebarre and Chevillard do ("Efficient polynomial L∞-approximations", ARITH 2007).

use super::{dot, subtract};

/// Lovász' condition.
const LOVASZ: f64 = 0.99;

/// Basis vectors as Chebyshev coefficients of unit vectors, and as integer combinations of the coefficients' units.
pub(super) struct Lattice {
    basis: Vec<Vec<f64>>,
    units: Vec<Vec<i64>>,
}

impl Lattice {
    /// Of the multiples of `lsb[k]`·vᵏ, with v = centre + radius·u and |u| ≤ 1.
    pub(super) fn of_powers(lsb: &[f64], centre: f64, radius: f64) -> Self {
        let n = lsb.len();
        let mut power = vec![0.0; n];
        power[0] = 1.0;
        let mut basis = Vec::with_capacity(n);
        for unit in lsb {
            let mut vector: Vec<f64> = power.iter().map(|c| unit * c).collect();
            vector[0] *= std::f64::consts::SQRT_2;
            basis.push(vector);
            // By v, with u·Tₖ = (Tₖ₊₁ + T|ₖ₋₁|)/2.
            let mut next: Vec<f64> = power.iter().map(|c| centre * c).collect();
            for (k, c) in power.iter().enumerate() {
                if k + 1 < n {
                    next[k + 1] += 0.5 * radius * c;
                }
                next[k.abs_diff(1)] += 0.5 * radius * c;
            }
            power = next;
        }
        let units = (0..n).map(|k| (0..n).map(|j| i64::from(j == k)).collect()).collect();
        let mut lattice = Lattice { basis, units };
        lattice.reduce();
        lattice
    }

    /// The basis vectors as Chebyshev series.
    pub(super) fn series(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        self.basis.iter().map(|b| {
            let mut series = b.clone();
            series[0] /= std::f64::consts::SQRT_2;
            series
        })
    }

    /// The Chebyshev series of a combination of the basis vectors.
    pub(super) fn sum(&self, factors: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.basis.len()];
        for (series, factor) in self.series().zip(factors) {
            subtract(&mut sum, -factor, &series);
        }
        sum
    }

    /// The coefficients, in their units, of a point of the lattice.
    pub(super) fn coefficients(&self, point: &[i64]) -> Vec<i64> {
        let column = |k: usize| self.units.iter().zip(point).map(|(u, x)| u[k] * x).sum();
        (0..self.units.len()).map(column).collect()
    }

    /// Babai: the coordinates of a point near a Chebyshev series.
    pub(super) fn nearest_plane(&self, series: &[f64]) -> Vec<i64> {
        let (vectors, lengths) = self.orthogonal();
        let mut rest: Vec<f64> =
            series.iter().copied().chain(std::iter::repeat(0.0)).take(self.basis.len()).collect();
        rest[0] *= std::f64::consts::SQRT_2;
        let mut point = vec![0; self.basis.len()];
        for k in (0..self.basis.len()).rev() {
            let factor = (dot(&rest, &vectors[k]) / lengths[k]).round();
            subtract(&mut rest, factor, &self.basis[k]);
            point[k] = factor as i64;
        }
        point
    }

    /// Gram–Schmidt vectors of the basis and their squared lengths.
    fn orthogonal(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(self.basis.len());
        let mut lengths = Vec::with_capacity(self.basis.len());
        for b in &self.basis {
            let mut v = b.clone();
            // Twice is enough (Kahan and Parlett).
            for _ in 0..2 {
                for (u, length) in vectors.iter().zip(&lengths) {
                    let factor = dot(&v, u) / length;
                    subtract(&mut v, factor, u);
                }
            }
            lengths.push(dot(&v, &v));
            vectors.push(v);
        }
        (vectors, lengths)
    }

    fn reduce(&mut self) {
        let n = self.basis.len();
        let mut k = 1;
        // The dimension is small; the orthogonal vectors are simply made anew after each change.
        let mut budget = 200 * n * n;
        while k < n && budget > 0 {
            budget -= 1;
            let (vectors, lengths) = self.orthogonal();
            for j in (0..k).rev() {
                let factor = (dot(&self.basis[k], &vectors[j]) / lengths[j]).round();
                if factor != 0.0 {
                    let (vector, units) = (self.basis[j].clone(), self.units[j].clone());
                    subtract(&mut self.basis[k], factor, &vector);
                    self.units[k].iter_mut().zip(&units).for_each(|(x, y)| *x -= factor as i64 * y);
                }
            }
            let mu = dot(&self.basis[k], &vectors[k - 1]) / lengths[k - 1];
            if lengths[k] < (LOVASZ - mu * mu) * lengths[k - 1] {
                self.basis.swap(k, k - 1);
                self.units.swap(k, k - 1);
                k = (k - 1).max(1);
            } else {
                k += 1;
            }
        }
    }
}
