//! Fits the angular error model of a scanning mirror to calibration recordings.
//!
//! A [`Recording`] is read and checked, [`fit()`] chooses the order of the polynomial by cross-validation and
//! identifies its coefficients, and [`Coefficients`] is the file that carries them on. Formulas and equation
//! numbers are those of Fan et al., "Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling
//! and Correction" (2019).

pub mod acceptance;
pub mod apply;
mod basis;
pub mod cli;
pub mod coefficients;
pub mod dependence;
mod double_double;
pub mod error_model;
pub mod faults;
pub mod figures;
mod fit;
mod geometry;
mod gram;
mod identify;
pub mod input;
pub mod limits;
pub mod mirror;
pub mod order;
pub mod output;
pub mod plant;
pub mod points;
mod pretty;
pub mod recording;
pub mod report;
pub mod statistics;
pub mod summary;
pub mod table;
pub mod terms;
pub mod text_safety;
mod trust_region;
pub mod turn;
pub mod units;
pub mod weights;

pub use apply::{Applied, ApplyError, ApplyNote, apply, apply_passing_over, apply_screened};
pub use basis::{Basis, MAX_ORDER};
pub use coefficients::Coefficients;
pub use error_model::{ErrorModel, Sensor};
pub use fit::{Calibrated, Fit, FitError, FitNote, Fitted, Options, Solver, check, choose_order, fit};
pub use mirror::{Mirror, MirrorError};
pub use recording::{Recording, RecordingError};

/// The embedded recording, made by the project's own simulation (`fitter/data/README.md`), and the mirror
/// that it is of, the paper's.
///
/// # Errors
/// Those of [`Recording::from_bytes`]; the embedded file has none.
pub fn default_recording() -> Result<(Recording, Mirror), RecordingError> {
    let recording = Recording::from_bytes("calibration.csv", include_bytes!("../data/calibration.csv"))?;
    Ok((recording, Mirror::paper()))
}
