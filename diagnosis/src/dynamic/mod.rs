//! Diagnosis of dynamic recordings: a drive goes in, a position comes out, the nominal mechanism is
//! simulated, the recording disagrees.

pub mod fault;
pub mod linear;
pub mod recording;
pub mod spectrum;

pub use fault::DynamicError;
pub use recording::DynamicRecording;
