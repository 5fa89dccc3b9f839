//! Recordings of real sensors, which stay outside the project: the folder that `ARCSMITH_RECORDINGS` names.

use std::path::PathBuf;

/// The recording of that name; where the folder is not named, one line says what is skipped.
///
/// # Panics
/// Where the folder is named and the recording is not in it: a test that was asked for cannot run.
pub fn real(name: &str, skipped: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("ARCSMITH_RECORDINGS") else {
        println!("skipped: {skipped} (ARCSMITH_RECORDINGS does not name the folder with {name})");
        return None;
    };
    let path = PathBuf::from(folder).join(name);
    assert!(path.is_file(), "{} is not there: {skipped} needs it", path.display());
    Some(path)
}
