//! The multivariable linear nominal of structures with many modes, and what such recordings show and
//! a linear model cannot: hysteresis inside the loop, and constant offsets.
//!
//! [`diagnose::diagnose_linear`] runs it all: [`plan`] chooses the rows, [`nominal`] identifies the linear
//! model ([`subspace`], then [`refine`]), [`hysteresis`] puts an [`operator`] into its loop ([`looped`]) and
//! fits it by [`sensitivity`], [`mod@offset`] looks for a constant, and [`verdict`] says what that amounts to.

pub mod diagnose;
pub mod file;
pub mod hysteresis;
pub mod initial;
pub mod looped;
pub mod marquardt;
pub mod modal;
pub mod nominal;
pub mod offset;
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
