//! The multivariable linear nominal of structures with many modes, and what such recordings show and
//! a linear model cannot: hysteresis inside the loop, and constant offsets.
//!
//! `diagnose` runs it all: `plan` chooses the rows, `nominal` identifies the linear model (`subspace`, then
//! `refine`), `hysteresis` puts an `operator` into its loop (`looped`) and fits it by `sensitivity`, [`mod@offset`] looks
//! for a constant, and `verdict` says what that amounts to.

pub(crate) mod diagnose;
pub mod file;
pub(crate) mod hysteresis;
pub(crate) mod initial;
pub(crate) mod looped;
pub(crate) mod modal;
pub(crate) mod nominal;
pub mod offset;
pub(crate) mod operator;
pub(crate) mod plan;
pub(crate) mod refine;
pub(crate) mod sensitivity;
pub(crate) mod subspace;
pub(crate) mod verdict;

#[cfg(test)]
mod tests;
