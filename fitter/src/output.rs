//! Writing a file whole or not at all: into a temporary neighbour, which is then renamed.

use std::io::Write;
use std::path::Path;

use thiserror::Error;

/// Why a file could not be written.
#[derive(Debug, Error)]
pub enum OutputError {
    #[error("{file}: is a directory, expected the name of a file to write; add a name")]
    IsDirectory { file: String },
    #[error("{file}: is the file that was read; write the result to another name")]
    SameAsInput { file: String },
    #[error("{file}: cannot be written ({reason}); give --out in a folder that exists and can be written")]
    Unwritable { file: String, reason: String },
}

/// Writes `path` by `write`, which is given the temporary file; the file appears under its name only when
/// all is written.
///
/// # Errors
/// One of [`OutputError`]; nothing is left behind.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), OutputError> {
    let file = path.display().to_string();
    if path.is_dir() {
        return Err(OutputError::IsDirectory { file });
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let attempt = || -> std::io::Result<()> {
        let mut temporary = tempfile::Builder::new().prefix(".writing-").tempfile_in(folder)?;
        {
            let mut buffered = std::io::BufWriter::new(temporary.as_file_mut());
            write(&mut buffered)?;
            buffered.flush()?;
        }
        // A temporary file is private; the result is an ordinary one, as the user's umask would have it.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(path).map_or(0o644, |old| old.permissions().mode());
            temporary.as_file().set_permissions(std::fs::Permissions::from_mode(mode))?;
        }
        temporary.persist(path).map_err(|error| error.error)?;
        Ok(())
    };
    attempt().map_err(|error| OutputError::Unwritable { file, reason: error.to_string() })
}

/// Refuses to write over the file that was read.
///
/// # Errors
/// [`OutputError::SameAsInput`].
pub fn not_the_input(output: &Path, inputs: &[&Path]) -> Result<(), OutputError> {
    let same = |input: &Path| match (output.canonicalize(), input.canonicalize()) {
        (Ok(output), Ok(input)) => output == input,
        _ => false,
    };
    match inputs.iter().any(|input| same(input)) {
        true => Err(OutputError::SameAsInput { file: output.display().to_string() }),
        false => Ok(()),
    }
}
