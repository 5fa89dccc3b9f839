//! All tests of this crate from outside, in one binary.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // how a test fails

mod bad_cell;
mod beyond;
mod budget;
mod compare;
mod contradictions;
mod diagnose;
mod fitting;
mod fleet;
mod front_door;
#[cfg(unix)]
mod hostile;
mod limits;
mod pages;
mod project;
mod sets;
mod simulation;
mod structures;
