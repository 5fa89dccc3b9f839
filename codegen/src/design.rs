//! What every method of evaluation comes to: a program with its bound.

use crate::bound::{Bound, Overflows};
use crate::exact::Interval;
use crate::output::{Output, OutputError};
use crate::physics::ErrorAccount;
use crate::program::{Program, Stage};

/// A routine as designed: program, bound, and what its output word stands for.
#[derive(Debug, Clone)]
pub struct Design {
    /// The whole program.
    pub program: Program,
    /// The bound, in the reference's unit.
    pub bound: Bound,
    /// Degree of the polynomial, or of each of the table's.
    pub degree: usize,
    /// Number of segments; 1 without a table.
    pub segments: usize,
    /// Supremum error of the best polynomial of this degree, before its coefficients were rounded.
    pub minimax: f64,
    /// What one output word (float: 1) stands for, in the reference's unit.
    pub unit: Interval,
    /// The last sum before the output's format is a word of 2^−`sum_bits` of the reference's unit (fixed point).
    pub sum_bits: i64,
    /// What is known of the steps of further physics, where there are any.
    pub account: Option<ErrorAccount>,
}

/// Why there is no design.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// The output cannot be expressed.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The terms of further physics cannot be generated.
    #[error(transparent)]
    Physics(crate::physics::PhysicsError),
    /// No format is coarse enough.
    #[error(transparent)]
    Overflows(#[from] Overflows),
}

impl DesignError {
    /// The same, told as what it is to the user: where only the step to `output` leaves its type, the output's
    /// unit is too fine for the range.
    #[must_use]
    pub fn for_output(self, output: Output) -> Self {
        match (&self, output.decimal_digits()) {
            (DesignError::Overflows(Overflows { stage: Stage::Output, .. }), Some(digits)) => {
                DesignError::Output(OutputError::Decimal { digits })
            }
            _ => self,
        }
    }
}
