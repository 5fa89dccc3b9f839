//! Recordings in Parquet.
//!
//! A program calls [`register`] once; from then on all that reads a recording reads it from Parquet too. A [`Dataset`]
//! holds the recordings of many units.

pub mod dataset;
mod file;

pub use dataset::Dataset;

use fitter::table::{Format, add_format};

/// Lets [`fitter::table::Table::read`] read Parquet files, in the whole process.
pub fn register() {
    add_format(Format { begins_with: *b"PAR1", read: file::read });
}
