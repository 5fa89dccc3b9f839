//! Progress on long work, on a terminal only.

use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result};

use super::Common;
use crate::Recording;
use crate::recording::Reading;

/// Shows that something goes on while a long recording is worked on, if someone is watching.
pub(super) fn waiting<T>(what: &'static str, rows: usize, common: Common, work: impl FnOnce() -> T) -> T {
    const LONG: usize = 200_000;
    if rows < LONG || !common.watched() {
        return work();
    }
    let spinner = ProgressBar::new_spinner().with_message(format!("{what} {rows} rows"));
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    let result = work();
    spinner.finish_and_clear();
    result
}

/// Reads a recording; a long one with a progress bar, if someone is watching.
pub(super) fn read(path: &Path, reading: &Reading, common: Common) -> Result<Recording> {
    const LONG: u64 = 20 << 20;
    let bytes = path.metadata().map_or(0, |data| data.len());
    if bytes < LONG || !common.watched() {
        return Recording::read_as(path, reading, &mut |_| {}).into_diagnostic();
    }
    let bar = ProgressBar::new(bytes);
    if let Ok(style) = ProgressStyle::with_template("reading {bar:40} {bytes}/{total_bytes} {eta}") {
        bar.set_style(style);
    }
    let recording = Recording::read_as(path, reading, &mut |read| bar.set_position(read));
    bar.finish_and_clear();
    recording.into_diagnostic()
}
