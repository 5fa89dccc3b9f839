//! All tests of this crate from outside, in one binary.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // how a test fails

mod apply;
mod common;
mod fit;
mod turn;
mod turn_beside;
