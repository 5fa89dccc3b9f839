//! Recordings in the frequency domain, as plain functions over plain arrays.
//!
//! A recording becomes a set of [`Experiments`]: spectra of drive and position on common lines, one for each
//! run of a periodic excitation (averaged over its periods), or one for each windowed segment of any other.
//! From them come the frequency response ([`frf`]: the best linear approximation where the excitation is
//! periodic, Welch's estimate otherwise), even and odd nonlinear distortion ([`distortion`]), what the
//! amplitude does to gain and resonances ([`growth`]), and power spectra ([`band`]).
//!
//! Source: R. Pintelon, J. Schoukens, *System Identification: A Frequency Domain Approach*, 2nd ed., 2012,
//! chapters 2 to 4.

pub mod band;
pub mod distortion;
pub mod experiments;
pub mod frf;
pub mod growth;

pub use experiments::Experiments;
pub use frf::{Response, response};

pub use numerics::Complex;
