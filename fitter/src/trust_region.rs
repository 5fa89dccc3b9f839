//! The paper's solver: the objective of Eq. 11 in all its parameters, Δd included, minimised by the trust
//! region method of Levenberg and Marquardt (the `levenberg-marquardt` crate, a port of MINPACK: Moré 1978).
//!
//! Eq. 11 cannot tell Δd from a₁; the trust region keeps the step short along that direction, and only the
//! combination a₁ − Δd/d is handed on. An independent way to the same minimum as [`crate::identify`].

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::double_double::Double;
use crate::fit::FitError;
use crate::identify::Problem;

/// The Jacobian is held whole; above so many rows the solver by QR is the way.
const MOST_ROWS: usize = 200_000;

/// Unknowns: q = Δd/d, scaled to the half-width of the readings, then the coefficients of the basis.
struct Objective<'a> {
    rows: &'a Problem<'a>,
    unknowns: DVector<f64>,
    jacobian: DMatrix<f64>,
    observed: DVector<f64>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Objective<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, unknowns: &DVector<f64>) {
        self.unknowns.copy_from(unknowns);
    }

    fn params(&self) -> DVector<f64> {
        self.unknowns.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(&self.observed + &self.jacobian * &self.unknowns)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.jacobian.clone())
    }
}

impl Problem<'_> {
    /// Coefficients of the basis by the trust region method; with `free_distance` Δd is a parameter of its
    /// own (an eddy-current pair).
    ///
    /// # Errors
    /// [`FitError::NoConvergence`], or [`FitError::TooManyRows`] above 200 000 rows.
    pub fn solve_trust_region(&self, free_distance: bool) -> Result<Vec<Double>, FitError> {
        let (rows, polynomials) = (self.reading.len(), self.order + 1);
        if rows > MOST_ROWS {
            return Err(FitError::TooManyRows { rows, most: MOST_ROWS });
        }
        let extra = usize::from(free_distance);
        let mut jacobian = DMatrix::zeros(rows, polynomials + extra);
        let mut observed = DVector::zeros(rows);
        let mut values = vec![0.0; polynomials];
        for row in 0..rows {
            let root = (self.weight)(row).sqrt();
            self.model_row(row, &mut values);
            let s = self.reading[row];
            if free_distance {
                // Δθ = gain [Σ c p − (Δd/d) s]: the residual Δθ_M − Δθ grows with Δd.
                jacobian[(row, 0)] = root * (self.gain)(s) * s;
            }
            for (k, value) in values.iter().enumerate() {
                jacobian[(row, k + extra)] = -root * value;
            }
            observed[row] = root * self.error[row];
        }
        let unknowns = DVector::zeros(polynomials + extra);
        let objective = Objective { rows: self, unknowns, jacobian, observed };
        let solver = LevenbergMarquardt::new().with_tol(1e-15).with_patience(200);
        let (objective, report) = solver.minimize(objective);
        use levenberg_marquardt::TerminationReason::NoImprovementPossible;
        if !report.termination.was_successful() && !matches!(report.termination, NoImprovementPossible(_)) {
            return Err(FitError::NoConvergence { reason: format!("{:?}", report.termination) });
        }
        let mut c: Vec<Double> =
            (extra..polynomials + extra).map(|k| Double::from(objective.unknowns[k])).collect();
        if free_distance {
            // −(Δd/d) s belongs to the linear polynomial; take it in by its coefficients in the basis.
            let (constant, linear) = objective.rows.basis.linear();
            let ratio = Double::from(objective.unknowns[0]);
            c[0] = c[0] - constant * ratio;
            c[1] = c[1] - linear * ratio;
        }
        Ok(c)
    }
}
