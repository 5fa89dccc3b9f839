//! The one kit of numerics: orthonormal bases, least squares, small symmetric and Hermitian systems, nonlinear least
//! squares, Fourier coefficients, statistics, work on several threads. Nothing here knows of a recording.
//!
//! Numbers that carry derivatives are in `physics`.

pub mod fourier;
pub mod hermitian;
mod least_squares;
mod marquardt;
mod orthogonal;
pub mod parallel;
mod statistics;
mod symmetric;

pub use least_squares::{LeastSquares, least_squares, of_triangle};
pub use marquardt::{Limits, Normal, minimise};
pub use orthogonal::{Basis, Columns, SingleColumns, add_scaled, dot};
pub use statistics::{centred, mean, mean_and_error, median, range, rms, student_95};
pub use symmetric::{Symmetric, cholesky, quadratic_form};

/// A complex number in double precision.
pub type Complex = rustfft::num_complex::Complex<f64>;

/// Length of what is left of a column after projection, relative to the column, below which it is rounding.
pub const DEPENDENT: f64 = 1e-7;
