//! Fits the angular error model of a scanning mirror to calibration recordings.

pub mod coefficients;
pub mod error_model;
pub mod units;
