//! Writing files whole, and sets of files together.
//!
//! Every command writes its files as a [`FileSet`]: all are put together in a hidden folder `.arcsmith-…` beside
//! their place, every write being checked, and then renamed one after the other with nothing in between.
//!
//! What holds:
//! - Every file is the old one or the new one, whole. A command that fails, a full disk included, changes nothing and
//!   leaves nothing behind, folders that it made included.
//! - A set is decided by one rename, that of its journal. A program that is killed before has changed nothing. One that
//!   is killed after, in the microseconds of the renames, leaves old and new files beside each other *and the journal*:
//!   the next command that writes into one of the folders first completes the set, and `check` and `verify` report it
//!   ([`interrupted`]).
//! - What a killed program leaves behind is removed by the next command that writes into the same folder. A hidden
//!   folder is locked while its program lives, and then left alone.
//! - Two programs that write sets into the same folder do so one after the other, unless one holds the folder for longer
//!   than two seconds.
//!
//! What does not hold: nothing is forced onto the medium, so that a power failure may lose what was written last. What
//! went into a device or a pipe is not taken back. A
//! program that reads several files between a kill and the next command sees them as they stand. A folder that is
//! moved in between loses the parts of its set that were outside it. Where a file system has no locks, leftovers stay.

mod set;
mod stage;

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::text_safety;

pub use set::FileSet;

errors! {
    /// Why a file could not be written.
    #[derive(Debug)]
    pub enum OutputError {
        IsDirectory { file: String } =>
            at(file) says("is a directory") expected("the name of a file to write") mend("add a name");
        SameAsInput { file: String } =>
            at(file) says("is the file that was read") mend("write the result to another name");
        NotARecording { file: String } =>
            says("`{file}` is no name for a recording") expected("one that ends in `.csv` or `.csv.gz`");
        Twice { file: String } =>
            at(file) says("two results of this command would have this name") mend("give one of them another");
        Unwritable { file: String, reason: String } =>
            at(file) says("cannot be written ({reason})")
            mend("write it into a folder that exists and can be written") by(out);
        Interrupted { file: String, reason: String } =>
            at(file) says("cannot be replaced ({reason}), but other files of the same set were")
            mend("mend that: the next command that writes into the folder completes the set first");
    }
}

impl OutputError {
    fn unwritable(path: &Path, error: &io::Error) -> OutputError {
        OutputError::Unwritable { file: text_safety::path(path), reason: error.kind().to_string() }
    }

    fn interrupted(path: &Path, error: &io::Error) -> OutputError {
        OutputError::Interrupted { file: text_safety::path(path), reason: error.kind().to_string() }
    }

    /// The same of the file that was asked for, where it is of its folder.
    fn about(self, path: &Path) -> OutputError {
        match self {
            OutputError::Unwritable { reason, .. } => {
                OutputError::Unwritable { file: text_safety::path(path), reason }
            }
            other => other,
        }
    }
}

/// Writes `path` by `write`, which is given the file; it appears under its name only when all is written. A device or
/// pipe is written to and stays what it is; a link stays one, and what it points to is replaced.
///
/// # Errors
/// One of [`OutputError`]; nothing is left behind.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    if is_special(path) {
        return write_special(path, write).map_err(|error| OutputError::unwritable(path, &error));
    }
    let mut set = FileSet::new();
    set.add(path, write)?;
    set.commit().map(drop)
}

/// Of a folder in which a program was interrupted while it replaced the files of a set: what it left there. The files
/// are of two sets until a command writes into the folder.
pub fn interrupted(folder: &Path) -> Option<PathBuf> {
    stage::interrupted(folder)
}

/// Whether a path is there and neither a file nor a folder.
fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir())
}

fn write_special(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    fill(&mut std::fs::OpenOptions::new().write(true).open(path)?, write)
}

fn fill(file: &mut File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = io::BufWriter::new(file);
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
mod tests;
