//! What every method of evaluation comes to: a program with its bound.

use crate::bound::{Bound, Overflows};
use crate::exact::Interval;
use crate::output::Output;
use crate::physics::{ErrorAccount, PhysicsError};
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
    /// No polynomial of this degree, whatever its coefficients, is nearer to the function than this; the best one is
    /// further by less than a thousandth.
    pub minimax: f64,
    /// What one output word (float: 1) stands for, in the reference's unit.
    pub unit: Interval,
    /// The last sum before the output's format is a word of 2^−`sum_bits` of the reference's unit (fixed point).
    pub sum_bits: i64,
    /// What is known of the steps of further physics, where there are any.
    pub account: Option<ErrorAccount>,
}

fitter::errors! {
    /// Why there is no design.
    #[derive(Debug, Clone, PartialEq)]
    pub enum DesignError {
        FloatOnly => says("float arithmetic gives a float") mend("use output f32, or a fixed-point format");
        /// A decimal unit too fine or too coarse for the range.
        Decimal { digits: u32 } =>
            says("10^-{digits} of the unit does not suit this range in 32 bits") mend("use another output");
        Physics(it: PhysicsError) => of(it);
    }
    from { Overflows(Overflows) }
}

impl From<PhysicsError> for DesignError {
    /// A word that overflows in a term is one of the design: with more headroom it may fit.
    fn from(cause: PhysicsError) -> Self {
        match cause {
            PhysicsError::Overflows(cause) => DesignError::Overflows(cause),
            cause => DesignError::Physics(cause),
        }
    }
}

impl DesignError {
    /// The same, told as what it is to the user: where only the step to `output` leaves its type, the output's
    /// unit is too fine for the range.
    #[must_use]
    pub fn for_output(self, output: Output) -> Self {
        match (&self, output.decimal_digits()) {
            (DesignError::Overflows(Overflows { stage: Stage::Output, .. }), Some(digits)) => {
                DesignError::Decimal { digits }
            }
            _ => self,
        }
    }
}
