//! What can go wrong.

use std::path::PathBuf;

/// Why a check could not be made, or what it found.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// Tools that this machine lacks.
    #[error("{0}")]
    Missing(String),
    /// A file of the tests could not be read or written.
    #[error("{path}: {cause}")]
    File {
        /// Which.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{path}: {message}")]
    Content {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// A program refused.
    #[error("{what}: {program} {outcome}\n{output}")]
    Refused {
        /// What was being done.
        what: String,
        /// The program.
        program: String,
        /// Its exit.
        outcome: String,
        /// The last lines that it printed.
        output: String,
    },
    /// Outputs differ from the host's.
    #[error("{what}: the digest of {inputs} outputs is {found}, on the host it is {expected}")]
    Digest {
        /// Case, core and variant.
        what: String,
        /// How many.
        inputs: u64,
        /// On the target.
        found: String,
        /// On the host.
        expected: String,
    },
    /// Figures differ from the committed ones.
    #[error("{0}")]
    Figures(String),
}

impl Problem {
    /// For `map_err` on a file's operation.
    pub fn file(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Problem {
        let path = path.into();
        move |cause| Problem::File { path, cause }
    }
}
