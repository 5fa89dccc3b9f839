//! Coefficients that a format can hold, chosen together so that the final supremum error is small.
//!
//! Rounding each coefficient alone leaves an error that the others could have taken up. Here the polynomials
//! that the format can express are seen as a lattice in the space of values at points of the range
//! (Brisebarre and Chevillard, "Efficient polynomial L∞-approximations", ARITH 2007): its basis is reduced
//! (Lenstra, Lenstra, Lovász), the lattice point nearest to the function is found (Babai's nearest plane),
//! and a local search along the reduced basis lowers the supremum norm further. Everything here is search
//! in `f64`; what comes out is bounded elsewhere, exactly.

use crate::exact::{Interval, Polynomial};

/// Sample points per coefficient.
const SAMPLES_PER_COEFFICIENT: usize = 12;
/// Lovász' condition.
const LOVASZ: f64 = 0.99;
/// Rounds of local search; each must improve.
const SEARCH_ROUNDS: usize = 60;

/// Integer corrections δₖ so that Σδₖ·lsbₖ·vᵏ comes close to `residual` (in the supremum norm) for v from
/// `from` to `to` (points). `lsb[k]` is what one unit of coefficient k stands for.
pub fn nearest(residual: &Polynomial, lsb: &[f64], from: &Interval, to: &Interval) -> Vec<i64> {
    let n = lsb.len();
    let count = SAMPLES_PER_COEFFICIENT * n;
    let centre = from.hull(to).midpoint();
    let radius = (to - &centre).to_f64();
    let points: Vec<f64> = (0..count)
        .map(|i| centre.to_f64() - radius * (std::f64::consts::PI * i as f64 / (count - 1) as f64).cos())
        .collect();
    let target: Vec<f64> = points.iter().map(|&v| residual.at(&Interval::from_f64(v)).to_f64()).collect();
    let mut lattice = Lattice {
        basis: (0..n).map(|k| points.iter().map(|v| lsb[k] * v.powi(k as i32)).collect()).collect(),
        units: (0..n).map(|k| (0..n).map(|j| i64::from(j == k)).collect()).collect(),
    };
    lattice.reduce();
    let (mut delta, mut rest) = lattice.nearest_plane(&target);
    lattice.descend(&mut delta, &mut rest);
    delta
}

/// Basis vectors as values at the points, and as integer combinations of the coefficients' units.
struct Lattice {
    basis: Vec<Vec<f64>>,
    units: Vec<Vec<i64>>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(x, y)| *x -= factor * y);
}

fn largest(a: impl Iterator<Item = f64>) -> f64 {
    a.map(f64::abs).fold(0.0, f64::max)
}

impl Lattice {
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

    /// b_k −= factor·b_j, both as values and as units.
    fn subtract(&mut self, k: usize, j: usize, factor: i64) {
        let (values, units) = (self.basis[j].clone(), self.units[j].clone());
        subtract(&mut self.basis[k], factor as f64, &values);
        self.units[k].iter_mut().zip(&units).for_each(|(x, y)| *x -= factor * y);
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
                    self.subtract(k, j, factor as i64);
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

    /// Babai: the combination whose values are near `target`, and what is left of the target.
    fn nearest_plane(&self, target: &[f64]) -> (Vec<i64>, Vec<f64>) {
        let (vectors, lengths) = self.orthogonal();
        let mut rest = target.to_vec();
        let mut sum = vec![0; self.basis.len()];
        for k in (0..self.basis.len()).rev() {
            let factor = (dot(&rest, &vectors[k]) / lengths[k]).round();
            self.take(k, factor as i64, &mut sum, &mut rest);
        }
        (sum, rest)
    }

    fn take(&self, k: usize, factor: i64, sum: &mut [i64], rest: &mut [f64]) {
        subtract(rest, factor as f64, &self.basis[k]);
        sum.iter_mut().zip(&self.units[k]).for_each(|(s, u)| *s += factor * u);
    }

    /// Steps along ±bᵢ and ±bᵢ±bⱼ while the supremum norm falls.
    fn descend(&self, sum: &mut [i64], rest: &mut [f64]) {
        let n = self.basis.len();
        let mut norm = largest(rest.iter().copied());
        for _ in 0..SEARCH_ROUNDS {
            let mut best: Option<(f64, [(usize, i64); 2])> = None;
            for i in 0..n {
                for a in [-1i64, 1] {
                    for j in i..n {
                        for b in if j == i { &[0i64][..] } else { &[-1, 1] } {
                            let moved = rest.iter().zip(&self.basis[i]).zip(&self.basis[j]);
                            let moved = moved.map(|((r, x), y)| r - a as f64 * x - *b as f64 * y);
                            let there = largest(moved);
                            if there < best.as_ref().map_or(norm, |(n, _)| *n) {
                                best = Some((there, [(i, a), (j, *b)]));
                            }
                        }
                    }
                }
            }
            let Some((there, moves)) = best else { break };
            moves.iter().for_each(|&(k, factor)| self.take(k, factor, sum, rest));
            norm = there;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial that the lattice holds is found exactly, however far away the search starts.
    #[test]
    fn a_lattice_point_is_found() {
        let lsb = [1e-3, 1e-3, 1e-3, 1e-3];
        let wanted = [17, -40, 3, 99];
        let residual = Polynomial::new(
            wanted.iter().zip(lsb).map(|(&w, l)| &Interval::from_int(w) * &Interval::from_f64(l)).collect(),
        );
        let half = Interval::from_f64(0.5);
        assert_eq!(nearest(&residual, &lsb, &-half.clone(), &half), wanted);
    }

    /// Choosing together beats rounding each coefficient alone.
    #[test]
    fn together_is_better_than_alone() {
        let lsb = [1.0; 6];
        let exact: Vec<f64> = vec![0.49, 0.48, -0.47, 0.46, -0.45, 0.5];
        let residual = Polynomial::new(exact.iter().map(|&c| Interval::from_f64(c)).collect());
        let half = Interval::from_f64(0.5);
        let delta = nearest(&residual, &lsb, &-half.clone(), &half);
        let supremum = |delta: &[i64]| {
            let rest = residual.sub(&Polynomial::new(delta.iter().map(|&d| Interval::from_int(d)).collect()));
            rest.supremum(&-half.clone(), &half, &Interval::from_f64(1e-6)).to_f64_up()
        };
        assert!(supremum(&delta) < supremum(&[0, 0, 0, 0, 0, 1]), "{delta:?}: {}", supremum(&delta));
    }
}
