//! Exact arithmetic for proofs: dyadic intervals and polynomials over them.

mod angle;
mod exponential;
mod interval;
mod polynomial;
mod series;

pub use angle::{arcsec_per_rad, cos_sin, pi};
pub use exponential::exp_minus;
pub use interval::Interval;
pub use polynomial::Polynomial;
pub use series::Function;
