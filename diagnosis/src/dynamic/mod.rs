//! Diagnosis of dynamic recordings: a drive goes in, a position comes out, the nominal mechanism is
//! simulated, the recording disagrees.

pub mod fault;
pub mod recording;

pub use fault::DynamicError;
pub use recording::DynamicRecording;
