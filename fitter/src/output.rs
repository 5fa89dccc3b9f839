//! Writing a file whole or not at all: into a temporary neighbour, which is then renamed.

use std::io::Write;
use std::path::Path;

use thiserror::Error;

use crate::text_safety;

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
/// all is written. A device or pipe is written to and stays what it is; a link stays one, and what it points to is
/// replaced.
///
/// # Errors
/// One of [`OutputError`]; nothing is left behind.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), OutputError> {
    let file = text_safety::path(path);
    if path.is_dir() {
        return Err(OutputError::IsDirectory { file });
    }
    place(path, write).map_err(|error| OutputError::Unwritable { file, reason: error.kind().to_string() })
}

fn place(path: &Path, write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> std::io::Result<()> {
    let there = std::fs::metadata(path).ok();
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        return fill(&mut std::fs::OpenOptions::new().write(true).open(path)?, write);
    }
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: the user's mask takes away what it takes away.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder.prefix(".writing-").tempfile_in(folder)?;
    fill(temporary.as_file_mut(), write)?;
    if let Some(there) = there {
        temporary.as_file().set_permissions(there.permissions())?;
    }
    temporary.persist(&target).map(drop).map_err(|error| error.error)
}

fn fill(
    file: &mut std::fs::File,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut buffered = std::io::BufWriter::new(file);
    write(&mut buffered)?;
    buffered.flush()
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
        true => Err(OutputError::SameAsInput { file: text_safety::path(output) }),
        false => Ok(()),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, symlink};

    fn write_text(path: &Path) -> Result<(), OutputError> {
        write_whole(path, |file| file.write_all(b"text"))
    }

    #[test]
    fn a_device_and_a_pipe_are_written_to_and_stay() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).unwrap()
        });
        write_text(&pipe).unwrap();
        assert_eq!(reader.join().unwrap(), "text");
        assert!(std::fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert!(matches!(write_text(Path::new("/dev/full")), Err(OutputError::Unwritable { .. })));
        assert!(std::fs::metadata("/dev/full").unwrap().file_type().is_char_device());
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "before").unwrap();
        symlink(&file, &link).unwrap();
        write_text(&link).unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "text");
    }
}
