//! Diagnosis of dynamic recordings: a drive goes in, a position comes out, the nominal mechanism is
//! simulated, the recording disagrees.

pub mod data;
pub mod dense;
pub mod diagnose;
mod drive_path;
pub mod effects;
pub mod estimate;
pub mod expected;
pub mod fault;
pub mod feedback;
pub mod floor;
pub mod gram;
pub mod interval;
mod judge;
pub mod lag;
pub mod linear;
pub mod machine;
pub mod model;
pub mod noise;
pub mod number;
pub mod plant;
pub mod recording;
pub mod remainder;
pub mod report;
pub mod score;
pub mod screen;
pub mod search;
pub mod signal;
pub mod simulate;
pub mod span;
pub mod spectrum;
pub mod start;
pub mod step;
pub mod structure;
pub mod turns;
pub mod verdict;

pub use diagnose::{DynamicOutcome, Options, OwnSimulation, diagnose};
pub use fault::DynamicError;
pub use recording::DynamicRecording;
