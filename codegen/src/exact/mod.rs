//! Exact arithmetic for proofs: dyadic intervals and polynomials over them.

mod interval;
mod polynomial;

pub use interval::Interval;
pub use polynomial::Polynomial;
