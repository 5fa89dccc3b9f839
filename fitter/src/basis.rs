//! Polynomials that are orthonormal over the readings of a recording (Forsythe 1957): the
//! well-conditioned basis in which everything is solved, and its conversion to powers of the reading.
//!
//! With u = (reading − centre)/half-width, p₀ = 1/ν₀ and
//! νₖ₊₁ pₖ₊₁ = (u − αₖ) pₖ − νₖ pₖ₋₁. A model row is gain·pₖ(u), the gain of Eq. 4.

use crate::double_double::Double;

/// Largest order that any recording is tried with.
pub const MAX_ORDER: usize = 15;

/// A family of polynomials p₀ … pₙ, orthonormal in Σ weight·gain² over given readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// The reading at u = 0.
    pub centre: f64,
    /// The distance in readings from u = 0 to u = 1.
    pub half_width: f64,
    alpha: Vec<f64>,
    norm: Vec<f64>,
}

impl Basis {
    /// The basis for readings with weights (weight·gain² of Eq. 4 included by the caller), up to `order`, or
    /// up to the highest order that the number of distinct readings determines.
    pub fn new(readings: &[f64], weights: &[f64], order: usize) -> Basis {
        let (low, high) =
            readings.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let (centre, half_width) = (0.5 * (low + high), (0.5 * (high - low)).max(f64::MIN_POSITIVE));
        let u: Vec<f64> = readings.iter().map(|x| (x - centre) / half_width).collect();
        let mut now: Vec<f64> = vec![1.0; u.len()];
        let mut before = vec![0.0; u.len()];
        let (mut alpha, mut norm) = (Vec::new(), Vec::new());
        for degree in 0..=order {
            let size = dot(weights, &now, &now).sqrt();
            // Where fewer distinct readings than parameters are left, the next polynomial vanishes on all.
            if degree > 0 && size < 1e-9 * norm[0] {
                break;
            }
            norm.push(size);
            now.iter_mut().for_each(|p| *p /= size);
            let shifted: Vec<f64> = u.iter().zip(&now).map(|(u, p)| u * p).collect();
            alpha.push(dot(weights, &shifted, &now));
            let next: Vec<f64> = (0..u.len())
                .map(|i| {
                    let recoil = if degree > 0 { size * before[i] } else { 0.0 };
                    shifted[i] - alpha[degree] * now[i] - recoil
                })
                .collect();
            before = std::mem::replace(&mut now, next);
        }
        Basis { centre, half_width, alpha, norm }
    }

    /// The highest order.
    pub fn order(&self) -> usize {
        self.norm.len() - 1
    }

    /// p₀ … of a reading into `values`, as many as it has room for (at most order + 1).
    pub fn evaluate(&self, reading: f64, values: &mut [f64]) {
        let u = (reading - self.centre) / self.half_width;
        let (mut before, mut now) = (0.0, 1.0 / self.norm[0]);
        for (degree, value) in values.iter_mut().enumerate() {
            *value = now;
            if degree + 1 < self.norm.len() {
                let recoil = if degree > 0 { self.norm[degree] * before } else { 0.0 };
                let next = ((u - self.alpha[degree]) * now - recoil) / self.norm[degree + 1];
                before = std::mem::replace(&mut now, next);
            }
        }
    }

    /// Σ cₖ pₖ in powers of (reading − `origin`), converted with some 30 digits and rounded once.
    pub(crate) fn rounded_powers(&self, c: &[Double], origin: f64) -> Vec<f64> {
        let rows = self.powers(origin, c.len() - 1);
        (0..c.len())
            .map(|power| rows.iter().zip(c).fold(Double::ZERO, |sum, (row, c)| sum + row[power] * *c).round())
            .collect()
    }

    /// Covariance of the coefficients of the powers of (reading − `origin`), from that of the basis.
    pub fn covariance_in_powers(&self, covariance: &[Vec<f64>], origin: f64) -> Vec<Vec<f64>> {
        let n = covariance.len();
        let rows = self.powers(origin, n - 1);
        let map = |k: usize, power: usize| rows[k][power].round();
        let half: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|l| (0..n).map(|k| map(k, i) * covariance[k][l]).sum()).collect())
            .collect();
        (0..n).map(|i| (0..n).map(|j| (0..n).map(|l| half[i][l] * map(l, j)).sum()).collect()).collect()
    }

    /// The reading itself in the basis: reading = first·p₀ + second·p₁. The order has to be 1 at least.
    pub(crate) fn linear(&self) -> (Double, Double) {
        // p₁ = ((reading − centre)/h − α₀) p₀/ν₁ and p₀ = 1/ν₀.
        let p0 = Double::from(self.norm[0]);
        let slope = p0 * self.norm[1] * self.half_width;
        let constant = (Double::from(self.centre) + Double::product(self.alpha[0], self.half_width)) * p0;
        (constant, slope)
    }

    /// Row k holds the coefficients of pₖ, k ≤ `order`, in powers of (reading − `origin`), to some 30 digits.
    pub(crate) fn powers(&self, origin: f64, order: usize) -> Vec<Vec<Double>> {
        let scale = Double::ONE / Double::from(self.half_width);
        let shift = (Double::from(origin) - Double::from(self.centre)) * scale;
        let mut rows: Vec<Vec<Double>> = Vec::with_capacity(order + 1);
        let mut first = vec![Double::ZERO; order + 1];
        first[0] = Double::ONE / Double::from(self.norm[0]);
        rows.push(first);
        for degree in 0..order {
            let offset = shift - Double::from(self.alpha[degree]);
            let next = (0..=order)
                .map(|power| {
                    let mut sum = rows[degree][power] * offset;
                    if power > 0 {
                        sum = sum + rows[degree][power - 1] * scale;
                    }
                    if degree > 0 {
                        sum = sum - rows[degree - 1][power] * self.norm[degree];
                    }
                    sum / Double::from(self.norm[degree + 1])
                })
                .collect();
            rows.push(next);
        }
        rows
    }
}

fn dot(weights: &[f64], a: &[f64], b: &[f64]) -> f64 {
    weights.iter().zip(a).zip(b).map(|((w, a), b)| w * a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readings(count: usize) -> Vec<f64> {
        (0..count).map(|i| -0.356 + 0.712 * i as f64 / (count - 1) as f64).collect()
    }

    #[test]
    fn is_orthonormal_over_its_readings() {
        let x = readings(35);
        let weights = vec![1.0; 35];
        let basis = Basis::new(&x, &weights, MAX_ORDER);
        assert_eq!(basis.order(), MAX_ORDER);
        let rows: Vec<Vec<f64>> = (x.iter())
            .map(|x| {
                let mut values = vec![0.0; 16];
                basis.evaluate(*x, &mut values);
                values
            })
            .collect();
        for i in 0..16 {
            for j in 0..=i {
                let product: f64 = rows.iter().map(|row| row[i] * row[j]).sum();
                approx::assert_abs_diff_eq!(product, f64::from(u8::from(i == j)), epsilon = 1e-10);
            }
        }
    }

    #[test]
    fn stops_where_the_readings_run_out() {
        assert_eq!(Basis::new(&readings(5), &[1.0; 5], MAX_ORDER).order(), 4);
    }

    #[test]
    fn powers_are_the_same_polynomials() {
        let x: Vec<f64> = readings(35).iter().map(|x| x + 0.05).collect();
        let basis = Basis::new(&x, &[1.0; 35], MAX_ORDER);
        let powers = basis.powers(0.0, MAX_ORDER);
        for x in x {
            let mut values = vec![0.0; 16];
            basis.evaluate(x, &mut values);
            for (row, value) in powers.iter().zip(values) {
                let sum = row.iter().rev().fold(Double::ZERO, |sum, a| sum * x + *a).round();
                approx::assert_abs_diff_eq!(sum, value, epsilon = 1e-11);
            }
        }
    }
}
