//! What is generated from: coefficients that can be evaluated and explain more than they leave, or of which someone
//! has said that they are to be used as they are.

use fitter::acceptance::{self, Refusal, Reservation};
use fitter::coefficients::Coefficients;

use crate::options::{OptionError, Options};

/// Why nothing is generated from these coefficients.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotAccepted {
    /// They cannot be evaluated.
    #[error("{0}; fit again")]
    Damaged(Refusal),
    /// A number among the options.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// They leave more than they explain.
    #[error(
        "{0}; record what varies and diagnose again, or give --accept-unexplained: the generated files then say so"
    )]
    Unexplained(Reservation),
}

/// Whether a routine may be made of these coefficients, and what its head has to say of them then.
///
/// # Errors
/// [`NotAccepted`], with the reason.
pub fn accepted(coefficients: &Coefficients, options: &Options) -> Result<Option<String>, NotAccepted> {
    options.within_limits()?;
    match acceptance::to_generate(coefficients, options.accept_unexplained) {
        Ok(reservation) => Ok(reservation.map(|open| {
            format!("{open}; it was generated all the same, as was asked for (--accept-unexplained)")
        })),
        Err(Refusal::Unexplained(reservation)) => Err(NotAccepted::Unexplained(reservation)),
        Err(damaged) => Err(NotAccepted::Damaged(damaged)),
    }
}
