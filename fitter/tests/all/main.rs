//! All tests of this crate from outside, in one binary.

mod apply;
mod common;
mod fit;
mod turn;
mod turn_beside;
