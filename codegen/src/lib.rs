//! Generates the firmware correction of a scanning mirror with a proven error bound.
//!
//! Coefficients ([`fitter`]) and [`options`] become a [`routine`]: the function (`reference`) is
//! approximated (`approximate`), its coefficients rounded to a format (`quantize`), written as a
//! [`program`] of typed operations, and bounded (`bound`). The program is printed (`emit`) in every [`language`],
//! with a [`certificate`].

pub mod accepted;
pub mod afford;
mod approximate;
mod bound;
pub mod budget;
pub mod builder;
pub mod certificate;
#[cfg(feature = "program")]
pub mod cli;
pub mod cost;
pub mod describe;
pub mod design;
pub mod devices;
mod emit;
mod exact;
pub mod explore;
mod extent;
pub mod files;
#[cfg(test)]
mod fixtures;
pub mod format;
mod fused;
pub mod gappa;
pub mod generate;
pub mod input;
pub mod interpret;
pub mod language;
mod name;
pub mod options;
pub mod output;
pub mod physics;
mod piecewise;
pub mod program;
pub mod quantity;
mod quantize;
mod reference;
pub mod render;
pub mod routine;
pub mod source;
pub mod tables;
pub mod text;
pub mod turn;
pub mod verify;

pub use builder::Builder;
