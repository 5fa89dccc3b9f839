//! All tests of this crate from outside, in one binary.

mod bad_cell;
mod contradictions;
mod diagnose;
mod fitting;
mod front_door;
#[cfg(unix)]
mod hostile;
mod limits;
mod sets;
mod simulation;
