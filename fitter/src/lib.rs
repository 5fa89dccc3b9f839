//! Fits the angular error model of a scanning mirror to calibration recordings.
//!
//! A [`Recording`] is read and checked, [`fit()`] chooses the order of the polynomial by cross-validation and
//! identifies its coefficients, and [`Coefficients`] is the file that carries them on. Formulas and equation
//! numbers are those of Fan et al., "Improving Angular Accuracy of a Scanning Mirror Based on Error Modeling
//! and Correction" (2019).
//!
//! Without the feature `fit` there are the coefficients, the error model and the terms alone.

#![cfg_attr(not(feature = "fit"), allow(dead_code))] // what only a fit calls

#[macro_use] // before what uses it
pub mod message;

pub mod acceptance;
#[cfg(feature = "fit")]
pub mod apply;
mod basis;
pub mod budget;
pub mod coefficients;
#[cfg(feature = "fit")]
pub mod dependence;
mod double_double;
pub mod error_model;
#[cfg(feature = "fit")]
pub mod faults;
pub mod figures;
#[cfg(feature = "fit")]
mod fit;
mod geometry;
#[cfg(feature = "fit")]
mod gram;
#[cfg(feature = "fit")]
mod identify;
pub mod input;
#[cfg(feature = "fit")]
mod keys;
pub mod limits;
#[cfg(feature = "fit")]
pub mod mirror;
#[cfg(feature = "fit")]
pub mod order;
pub mod output;
#[cfg(feature = "fit")]
pub mod plant;
#[cfg(feature = "fit")]
pub mod points;
mod pretty;
pub mod progress;
pub mod recording;
#[cfg(feature = "fit")]
pub mod statistics;
pub mod table;
pub mod terms;
pub mod text_safety;
#[cfg(feature = "fit")]
mod trust_region;
pub mod turn;
pub mod units;
#[cfg(feature = "fit")]
pub mod weights;

#[cfg(feature = "fit")]
pub use apply::{Applied, ApplyError, ApplyNote, apply, apply_passing_over, apply_screened};
pub use basis::{Basis, MAX_ORDER};
pub use coefficients::Coefficients;
pub use error_model::{ErrorModel, Sensor};
#[cfg(feature = "fit")]
pub use fit::{Calibrated, Fit, FitError, FitNote, Fitted, Options, Solver, check, choose_order, fit};
#[cfg(feature = "fit")]
pub use keys::KeyError;
#[cfg(feature = "fit")]
pub use mirror::Mirror;
pub use recording::Recording;
#[cfg(feature = "fit")]
pub use recording::RecordingError;

/// The embedded recording, made by the project's own simulation (`fitter/data/README.md`), and the mirror
/// that it is of, the paper's.
///
/// # Errors
/// Those of [`Recording::from_bytes`]; the embedded file has none.
#[cfg(feature = "fit")]
pub fn default_recording() -> Result<(Recording, Mirror), RecordingError> {
    let recording = Recording::from_bytes("calibration.csv", include_bytes!("../data/calibration.csv"))?;
    Ok((recording, Mirror::paper()))
}
