//! The multivariable linear nominal of structures with many modes, and the one effect that such recordings
//! show and that a linear model cannot: hysteresis inside the loop.
//!
//! [`diagnose::diagnose_linear`] runs it all: [`plan`] chooses the rows, [`nominal`] identifies the linear
//! model ([`subspace`], then [`refine`]), [`hysteresis`] puts an [`operator`] into its loop ([`looped`]) and
//! fits it by [`sensitivity`], and [`verdict`] says what that amounts to.

pub mod diagnose;
pub mod file;
pub mod hysteresis;
pub mod initial;
pub mod looped;
pub mod marquardt;
pub mod modal;
pub mod nominal;
pub mod operator;
pub mod plan;
pub mod refine;
pub mod sensitivity;
pub mod subspace;
pub mod verdict;

pub use diagnose::diagnose_linear;

use crate::dynamic::spectrum::Complex;

#[cfg(test)]
mod tests;
