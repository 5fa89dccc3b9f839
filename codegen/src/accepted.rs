//! What is generated from: coefficients that can be evaluated and explain more than they leave, or of which someone
//! has said that they are to be used as they are.

use fitter::acceptance::{self, Refusal, Reservation};
use fitter::coefficients::Coefficients;

use crate::options::Options;

fitter::errors! {
    /// Why nothing is generated from these coefficients.
    #[derive(Debug, Clone, PartialEq)]
    pub enum NotAccepted {
        Damaged(it: Refusal) => says("{it}") mend("fit again");
        /// A number that nothing can be computed with.
        Number { of: String, reason: String, value: &'static str } =>
            says("{of} {reason}") mend("give a number that a sensor can have") by_name(value);
        Unexplained(it: Reservation) =>
            says("{it}")
            mend("record what varies and diagnose again, or accept it as it is: the generated files then say so")
            by(accept_unexplained);
    }
}

/// Whether a routine may be made of these coefficients, and what its head has to say of them then.
///
/// # Errors
/// [`NotAccepted`], with the reason.
pub fn accepted(coefficients: &Coefficients, options: &Options) -> Result<Option<String>, NotAccepted> {
    options.within_limits()?;
    match acceptance::to_generate(coefficients, options.accept_unexplained) {
        Ok(reservation) => {
            Ok(reservation.map(|open| format!("{open}; it was generated all the same, as was asked for")))
        }
        Err(Refusal::Unexplained(reservation)) => Err(NotAccepted::Unexplained(reservation)),
        Err(damaged) => Err(NotAccepted::Damaged(damaged)),
    }
}
