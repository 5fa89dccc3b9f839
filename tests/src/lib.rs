//! What the cross-crate tests share: devices at random, inputs and what they mean, the generated sources
//! compiled and loaded, the project's programs from outside, and the paper's experiment on simulated mirrors.

pub mod committed;
pub mod devices;
pub mod documents;
pub mod fuzz;
pub mod inputs;
pub mod judge;
pub mod native;
pub mod paper;
pub mod programs;
pub mod recordings;
pub mod toolchain;
