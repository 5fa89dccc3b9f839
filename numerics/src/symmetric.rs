//! Small dense symmetric systems: the normal equations of an estimate with a dozen unknowns.

use super::orthogonal::dot;

/// A symmetric matrix by rows.
#[derive(Debug, Clone)]
pub struct Symmetric {
    /// Number of rows.
    pub size: usize,
    /// All entries, row by row.
    pub entries: Vec<f64>,
}

impl Symmetric {
    /// Zero.
    pub fn zero(size: usize) -> Symmetric {
        Symmetric { size, entries: vec![0.0; size * size] }
    }

    /// Entry (i, j).
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[i * self.size + j]
    }

    /// Entry (i, j), to be changed.
    pub fn at_mut(&mut self, i: usize, j: usize) -> &mut f64 {
        &mut self.entries[i * self.size + j]
    }

    /// Its rows and columns `lanes`.
    pub fn part(&self, lanes: impl IntoIterator<Item = usize>) -> Symmetric {
        let lanes: Vec<usize> = lanes.into_iter().collect();
        let entries = lanes.iter().flat_map(|i| lanes.iter().map(|j| self.at(*i, *j))).collect();
        Symmetric { size: lanes.len(), entries }
    }

    /// The lower Cholesky factor of the matrix scaled to a unit diagonal, and the scale; directions that
    /// are dependent to rounding are switched off (their scale is zero).
    pub fn factor(&self) -> Factor {
        let n = self.size;
        let scale: Vec<f64> = (0..n)
            .map(|i| {
                let d = self.at(i, i);
                if d > 0.0 && d.is_finite() { 1.0 / d.sqrt() } else { 0.0 }
            })
            .collect();
        let mut factor = Factor { size: n, lower: vec![0.0; n * n], scale };
        for i in 0..n {
            for j in 0..=i {
                let mut sum = self.at(i, j) * factor.scale[i] * factor.scale[j];
                for k in 0..j {
                    sum -= factor.lower[i * n + k] * factor.lower[j * n + k];
                }
                if i != j {
                    let pivot = factor.lower[j * n + j];
                    factor.lower[i * n + j] = if pivot.is_finite() { sum / pivot } else { 0.0 };
                } else if sum > 1e-12 {
                    factor.lower[i * n + i] = sum.sqrt();
                } else {
                    factor.scale[i] = 0.0;
                    factor.lower[i * n + i] = f64::INFINITY;
                }
            }
        }
        factor
    }
}

/// A Cholesky factor.
pub struct Factor {
    size: usize,
    lower: Vec<f64>,
    scale: Vec<f64>,
}

impl Factor {
    /// Solves for one right-hand side; unknowns that are switched off stay zero.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut x: Vec<f64> = right.iter().zip(&self.scale).map(|(r, s)| r * s).collect();
        for i in 0..n {
            let sum: f64 = (0..i).map(|k| self.lower[i * n + k] * x[k]).sum();
            x[i] = (x[i] - sum) / self.lower[i * n + i];
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| self.lower[k * n + i] * x[k]).sum();
            x[i] = (x[i] - sum) / self.lower[i * n + i];
        }
        for (x, s) in x.iter_mut().zip(&self.scale) {
            *x *= s;
        }
        x
    }

    /// The inverse.
    pub fn inverse(&self) -> Symmetric {
        let n = self.size;
        let mut inverse = Symmetric::zero(n);
        let mut unit = vec![0.0; n];
        for j in 0..n {
            unit[j] = 1.0;
            for (i, value) in self.solve(&unit).into_iter().enumerate() {
                *inverse.at_mut(i, j) = value;
            }
            unit[j] = 0.0;
        }
        inverse
    }
}

/// Cholesky factor (lower, by rows) of a symmetric positive definite matrix, and its log-determinant;
/// columns that are dependent get a unit pivot and are left out of the determinant.
pub fn cholesky(matrix: &[f64], n: usize) -> (Vec<f64>, f64) {
    let mut l = vec![0.0; n * n];
    let mut log_determinant = 0.0;
    for i in 0..n {
        for j in 0..=i {
            let sum = matrix[i * n + j] - dot(&l[i * n..i * n + j], &l[j * n..j * n + j]);
            if i == j {
                if sum > 1e-10 * matrix[i * n + i] && sum > 0.0 {
                    l[i * n + i] = sum.sqrt();
                    log_determinant += sum.ln();
                } else {
                    for k in 0..i {
                        l[i * n + k] = 0.0;
                    }
                    l[i * n + i] = f64::INFINITY;
                }
            } else {
                l[i * n + j] = sum / l[j * n + j];
            }
        }
    }
    (l, log_determinant)
}

/// ‖L⁻¹ b‖², the quadratic form bᵀ(LLᵀ)⁻¹b.
pub fn quadratic_form(l: &[f64], b: &[f64]) -> f64 {
    let n = b.len();
    let mut z = vec![0.0; n];
    for i in 0..n {
        let sum = b[i] - dot(&l[i * n..i * n + i], &z[..i]);
        z[i] = sum / l[i * n + i];
    }
    dot(&z, &z)
}
