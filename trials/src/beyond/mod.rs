//! Trials beyond the catalogue: physics that no table of effects holds is concealed, `diagnose` runs blind, and what it
//! hands on is tried on a fresh recording of the same device.
//!
//! Recordings are made by the scanning mirror of [`twin`], by its position sensor and by a mechanism in motion. What of the error can be corrected
//! at all is measured by an oracle: base polynomial and the concealed physics itself, with its true shape, fitted to the
//! recording by least squares. The gain that is realised is the part of the oracle's that the handed-on model reaches.

pub mod campaign;
mod draw;
mod lab;
mod mirror;
mod motion;
mod oracle;
pub mod plan;
pub mod report;
pub mod score;
mod sensor;
