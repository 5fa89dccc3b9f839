//! All tests of this crate from outside, in one binary.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // how a test fails

mod budget;
mod cost;
mod devices;
mod direct;
mod language;
mod physics;
mod tables;
mod turn;
