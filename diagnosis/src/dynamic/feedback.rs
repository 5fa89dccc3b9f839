//! Recordings under feedback: the drive is what is predicted and scored.

use fitter::plant::Plant;

use super::diagnose::{DynamicOutcome, Options};
use super::fault::DynamicError;
use super::recording::DynamicRecording;

/// Diagnoses a recording that was taken under feedback.
///
/// # Errors
/// One of [`DynamicError`].
pub fn diagnose(
    recording: &DynamicRecording,
    _nominal: &Plant,
    _held_out: Option<&DynamicRecording>,
    _options: &Options,
) -> Result<DynamicOutcome, DynamicError> {
    Err(DynamicError::NoPlant { file: recording.file.clone(), percent: 100.0 })
}
