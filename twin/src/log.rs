//! The log of a recording: its rows, and the CSV file that they are written to.

use std::io::{self, Write};
use std::path::Path;

use fitter::output::{OutputError, write_whole};
use fitter::text_safety;
use flate2::{Compression, GzBuilder};
use motion::Series;
use serde::Deserialize;

/// One settled reading, in the units of the CSV columns and with the resolution that they print.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Reading {
    /// Time since the start in seconds.
    pub t_s: f64,
    /// Number of the pass, from 1.
    pub pass: u32,
    /// +1 forward, −1 backward.
    pub direction: i8,
    /// Commanded angle in degrees.
    pub command_deg: f64,
    /// Displacement at probe 1 in millimetres, Eq. 2.
    pub x1_mm: f64,
    /// Displacement at probe 2 in millimetres, Eq. 3.
    pub x2_mm: f64,
    /// Autocollimator reading of the mirror angle in arcseconds, α₀ included.
    pub reference_arcsec: f64,
    /// Second axis of the autocollimator in arcseconds.
    pub cross_arcsec: f64,
    /// Base plate in °C.
    pub temperature_c: f64,
    /// Voice-coil current in A.
    pub coil_a: f64,
}

/// The header row.
pub(crate) const HEADER: &str =
    "t_s,pass,direction,command_deg,x1_mm,x2_mm,reference_arcsec,cross_arcsec,temperature_c,coil_a";

/// Writes the rows as CSV, header first.
pub fn write_csv(readings: &[Reading], mut to: impl Write) -> io::Result<()> {
    writeln!(to, "{HEADER}")?;
    for r in readings {
        writeln!(
            to,
            "{:.2},{},{},{:.3},{:.7},{:.7},{:.3},{:.3},{:.3},{:.5}",
            r.t_s,
            r.pass,
            r.direction,
            r.command_deg,
            r.x1_mm,
            r.x2_mm,
            r.reference_arcsec,
            r.cross_arcsec,
            r.temperature_c,
            r.coil_a
        )?;
    }
    to.flush()
}

/// Writes the rows to the file at `path`, `.csv` or `.csv.gz`. The file appears whole or not at all.
pub fn write_file(readings: &[Reading], path: &Path) -> Result<(), OutputError> {
    write_as(path, |to| write_csv(readings, to))
}

/// Writes a recording of a motion with so many decimals of time, drive and position to the file at `path`, `.csv` or
/// `.csv.gz`. The file appears whole or not at all.
///
/// # Errors
/// [`OutputError`].
pub fn write_series(series: &Series, decimals: Option<[usize; 3]>, path: &Path) -> Result<(), OutputError> {
    write_as(path, |to| series.write_csv(decimals, to))
}

/// Lets `fill` write the file at `path`, packed where its name ends in `.csv.gz`. The file appears whole or not
/// at all.
pub(crate) fn write_as(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let compressed = name.ends_with(".csv.gz");
    if !compressed && !name.ends_with(".csv") {
        return Err(OutputError::NotARecording { file: text_safety::path(path) });
    }
    write_whole(path, |to| {
        if compressed {
            // No name and no time in the head: the same recording is the same bytes.
            let mut packed = GzBuilder::new().write(to, Compression::best());
            fill(&mut packed)?;
            packed.finish().map(drop)
        } else {
            fill(to)
        }
    })
}
