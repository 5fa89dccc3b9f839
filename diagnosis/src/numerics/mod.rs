//! The one kit of numerics: orthonormal bases, least squares, small symmetric and Hermitian systems, numbers with
//! derivatives (from `physics`), nonlinear least squares, statistics. Nothing here knows of a recording.

pub mod hermitian;
mod least_squares;
mod marquardt;
mod orthogonal;
mod statistics;
mod symmetric;

pub use least_squares::{LeastSquares, least_squares, of_triangle};
pub use marquardt::{Limits, Normal, minimise};
pub use orthogonal::{Basis, Columns, add_scaled, dot};
pub use physics::number::{Dual, Number};
pub use statistics::{centred, mean, mean_and_error, median, range, rms, widening};
pub use symmetric::{Symmetric, cholesky, quadratic_form};
