//! The proof on concealed effects: recordings are drawn with effects hidden in them by `twin`, `diagnose` is
//! run on the recordings alone, and its answers are scored against a truth that was sealed before.
//!
//! Beside it, [`budget`] holds the stated uncertainty of corrected readings against simulated devices, and [`fleet`] what is
//! said of many devices together.
//!
//! What counts as right is in [`score`], what strength means in `matched.rs`, and which trials there are in
//! [`plan`].

mod answer;
mod benchmark;
pub mod beyond;
pub mod budget;
pub mod campaign;
pub mod compare;
mod curve;
pub mod draw;
pub mod dynamic;
mod error;
pub mod examples;
pub mod fleet;
mod formulas;
mod fresh;
mod linear;
mod matched;
pub mod plan;
pub mod programs;
pub mod real;
pub mod report;
pub mod score;
mod statistics;
pub mod truth;
pub mod workspace;

pub use error::CampaignError;
