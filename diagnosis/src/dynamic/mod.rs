//! Diagnosis of dynamic recordings: a drive goes in, a position comes out, the nominal mechanism is
//! simulated, the recording disagrees.

mod data;
mod dense;
pub mod diagnose;
mod drive_path;
pub mod effects;
mod estimate;
mod expected;
mod fault;
mod feedback;
mod floor;
mod gram;
mod interval;
mod judge;
mod lag;
pub mod linear;
mod machine;
pub mod model;
mod noise;
mod number;
pub mod plant;
mod recording;
mod remainder;
pub mod report;
mod score;
mod screen;
mod search;
mod signal;
mod simulate;
mod span;
mod spectrum;
mod start;
mod step;
mod structure;
mod turns;
mod verdict;

pub use diagnose::{DynamicOutcome, Options, OwnSimulation, diagnose};
pub use fault::DynamicError;
#[doc(hidden)]
pub use feedback::filter::low_pass;
pub use recording::DynamicRecording;

#[cfg(test)]
mod tests;
