//! Progress on long recordings.

use std::path::Path;

use fitter::Recording;
use fitter::recording::Reading;

use crate::terminal::{Common, Result};

/// Shows that something goes on while a long recording is worked on, if someone is watching.
pub fn waiting<T>(what: &str, rows: usize, common: Common, work: impl FnOnce() -> T) -> T {
    const LONG: usize = 200_000;
    if rows < LONG {
        return work();
    }
    let spinner = common.progress(0, "{spinner} {msg}");
    spinner.set_message(format!("{what} {rows} rows"));
    let result = work();
    spinner.finish_and_clear();
    result
}

/// Reads a recording; a long one with a progress bar, if someone is watching.
pub fn read(path: &Path, reading: &Reading, common: Common) -> Result<Recording> {
    const LONG: u64 = 20 << 20;
    let bytes = path.metadata().map_or(0, |data| data.len());
    if bytes < LONG {
        return Ok(Recording::read_as(path, reading, &mut |_| {})?);
    }
    let bar = common.progress(bytes, "reading {bar:40} {bytes}/{total_bytes} {eta}");
    let recording = Recording::read_as(path, reading, &mut |read| bar.set_position(read));
    bar.finish_and_clear();
    Ok(recording?)
}
