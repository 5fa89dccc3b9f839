//! Diagnosis of dynamic recordings: a drive goes in, a position comes out, the nominal mechanism is
//! simulated, the recording disagrees.

mod accurate;
mod amplifier;
pub(crate) mod candidates;
pub(crate) mod data;
pub mod diagnose;
mod drive_path;
pub mod effects;
pub mod equations;
mod estimate;
mod expected;
pub(crate) mod feedback;
mod floor;
mod gram;
mod interval;
pub(crate) mod joint;
mod judge;
mod lag;
pub mod linear;
mod machine;
pub mod model;
mod noise;
pub mod plant;
mod recording;
mod remainder;
mod score;
mod screen;
pub(crate) mod search;
mod signal;
mod simulate;
mod span;
pub(crate) mod spectrum;
mod start;
mod step;
mod structure;
mod turns;
mod verdict;

pub use diagnose::{Case, DynamicOutcome, Options, OwnSimulation, diagnose};
#[doc(hidden)]
pub use feedback::filter::low_pass;
pub use recording::{DynamicRecording, Reading};
pub(crate) use verdict::place;

#[cfg(test)]
mod tests;
