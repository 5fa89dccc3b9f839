//! Levenberg–Marquardt on normal equations: for problems whose Jacobian is summed up piece by piece and
//! never held whole.
//!
//! Source: D. Marquardt, SIAM J. Appl. Math. 11 (1963) 431–441; the damping follows Nielsen's rule
//! (K. Madsen, H. B. Nielsen, O. Tingleff, *Methods for non-linear least squares problems*, 2004, Eq. 2.21).

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, Par, Side};

/// The normal equations: Σ r², JᵀJ and Jᵀr at a point.
pub struct Normal {
    /// Σ r².
    pub cost: f64,
    /// JᵀJ, its lower triangle.
    pub gram: Mat<f64>,
    /// Jᵀ r.
    pub gradient: Vec<f64>,
}

impl Normal {
    /// Nothing yet of `size` parameters.
    pub fn zeros(size: usize) -> Normal {
        Normal { cost: 0.0, gram: Mat::zeros(size, size), gradient: vec![0.0; size] }
    }

    /// Adds rows: `jacobian` (rows × parameters) and their residuals.
    pub fn add(&mut self, jacobian: &Mat<f64>, residual: &[f64]) {
        triangular::matmul(
            self.gram.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            jacobian.transpose(),
            BlockStructure::Rectangular,
            jacobian.as_ref(),
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        for (k, g) in self.gradient.iter_mut().enumerate() {
            *g += super::dot(jacobian.col_as_slice(k), residual);
        }
        self.cost += residual.iter().map(|r| r * r).sum::<f64>();
    }

    /// Adds another piece.
    pub fn merge(&mut self, other: &Normal) {
        self.cost += other.cost;
        self.gram += &other.gram;
        for (a, b) in self.gradient.iter_mut().zip(&other.gradient) {
            *a += b;
        }
    }

    /// The damped step −(JᵀJ + λ diag)⁻¹ Jᵀr.
    fn step(&self, damping: f64) -> Option<Vec<f64>> {
        let n = self.gradient.len();
        let largest = (0..n).map(|i| self.gram[(i, i)]).fold(0.0, f64::max);
        let diagonal: Vec<f64> =
            (0..n).map(|i| self.gram[(i, i)].max(1e-14 * largest).max(f64::MIN_POSITIVE).sqrt()).collect();
        let scaled = Mat::from_fn(n, n, |i, j| {
            let own = if i == j { damping } else { 0.0 };
            self.gram[(i.max(j), i.min(j))] / (diagonal[i] * diagonal[j]) + own
        });
        let right = Mat::from_fn(n, 1, |i, _| -self.gradient[i] / diagonal[i]);
        let solved = scaled.llt(Side::Lower).ok()?.solve(&right);
        let step: Vec<f64> = (0..n).map(|i| solved[(i, 0)] / diagonal[i]).collect();
        step.iter().all(|s| s.is_finite()).then_some(step)
    }
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Most accepted steps.
    pub steps: usize,
    /// Relative decrease of the cost below which it has converged.
    pub decrease: f64,
}

/// Minimises Σ r² from `start`. `normal` gives the normal equations at a point, `cost` Σ r² alone; both give
/// `None` where the point is not admissible (an unstable model), which only shortens the step.
pub fn minimise(
    start: Vec<f64>,
    normal: impl Fn(&[f64]) -> Option<Normal>,
    cost: impl Fn(&[f64]) -> Option<f64>,
    limits: Limits,
) -> Vec<f64> {
    let mut at = start;
    let (mut damping, mut growth) = (1e-3, 2.0);
    for _ in 0..limits.steps {
        let Some(equations) = normal(&at) else { return at };
        let mut taken = None;
        for _ in 0..12 {
            let trial = equations.step(damping).map(|step| {
                let next: Vec<f64> = at.iter().zip(&step).map(|(a, s)| a + s).collect();
                let value = cost(&next).filter(|v| v.is_finite()).unwrap_or(f64::INFINITY);
                (next, value)
            });
            match trial {
                Some((next, value)) if value < equations.cost => {
                    taken = Some((next, value));
                    damping = (damping / 5.0f64).max(1e-9);
                    growth = 2.0;
                    break;
                }
                _ => {
                    damping *= growth;
                    growth *= 2.0;
                }
            }
        }
        let Some((next, value)) = taken else { return at };
        at = next;
        if equations.cost - value < limits.decrease * equations.cost {
            return at;
        }
    }
    at
}
