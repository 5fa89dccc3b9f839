//! Where the coefficients come from: a file, a recording that is fitted here, or the embedded recording.

use std::path::{Path, PathBuf};

use fitter::coefficients::Coefficients;
use fitter::message::Message;
#[cfg(feature = "recordings")]
use fitter::{Mirror, Recording, text_safety};

use crate::generate::sha256;

/// What the user named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// A coefficients file.
    Coefficients(PathBuf),
    /// A recording and its nominal mirror.
    #[cfg(feature = "recordings")]
    Recording {
        /// The recording.
        recording: PathBuf,
        /// The mirror.
        mirror: PathBuf,
    },
    /// The recording that is embedded in `fitter`.
    #[cfg(feature = "recordings")]
    Embedded,
}

impl Source {
    /// The files that it reads.
    pub fn files(&self) -> Vec<&Path> {
        match self {
            Source::Coefficients(path) => vec![path],
            #[cfg(feature = "recordings")]
            Source::Recording { recording, mirror } => vec![recording, mirror],
            #[cfg(feature = "recordings")]
            Source::Embedded => Vec::new(),
        }
    }

    /// The coefficients and the SHA-256 of their file (where they were fitted here: of the file that `fit`
    /// would have written).
    ///
    /// # Errors
    /// A [`Message`] where a file cannot be read or the fit fails.
    pub fn load(&self) -> Result<(Coefficients, String), Message> {
        match self {
            Source::Coefficients(path) => {
                let (coefficients, text) = fitter::coefficients::read_with_text(path)?;
                Ok((coefficients, sha256(&text)))
            }
            #[cfg(feature = "recordings")]
            Source::Recording { recording, mirror } => {
                let mirror = Mirror::read(mirror)?;
                let command = text_safety::command(&format!("arcsmith fit {}", recording.display()));
                fitted(&Recording::read(recording)?, &mirror, &command)
            }
            #[cfg(feature = "recordings")]
            Source::Embedded => {
                let (recording, mirror) = fitter::default_recording()?;
                fitted(&recording, &mirror, "arcsmith fit (the embedded recording)")
            }
        }
    }
}

#[cfg(feature = "recordings")]
fn fitted(recording: &Recording, mirror: &Mirror, command: &str) -> Result<(Coefficients, String), Message> {
    let options = fitter::Options { command: command.into(), ..fitter::Options::default() };
    let coefficients = fitter::fit(recording, mirror, &options)?.coefficients;
    let sha256 = sha256(coefficients.to_json());
    Ok((coefficients, sha256))
}
