//! Why a dynamic recording, or what was given with it, is refused: one message each, which says where, what
//! was found, what was expected and how to mend it.

use fitter::RecordingError;
use motion::series::SeriesError;
use thiserror::Error;

/// Why a dynamic diagnosis is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the messages say what the fields are
pub enum DynamicError {
    /// What can be wrong with any recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Rows that are not equidistant, or too few.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// Too much of the recording cannot be readings.
    #[error(transparent)]
    Faults(#[from] Box<fitter::faults::FaultError>),
    #[error(
        "{file}, column `{column}`: found the constant {value}, expected a drive that moves the mechanism; \
         excite it (multisine, sweep, steps) and record again"
    )]
    ConstantDrive { file: String, column: String, value: f64 },
    #[error(
        "{file}, column `{column}`: found the constant {value}, expected a position that follows the drive; \
         check the sensor"
    )]
    ConstantPosition { file: String, column: String, value: f64 },
    #[error(
        "{file}, line {line}, column `{column}`: the reading stands at its {end} {value} for {rows} rows in \
         all and is cut off there, expected a read-out within its range; reduce the drive or extend the range"
    )]
    Saturated { file: String, line: u64, column: String, end: &'static str, value: f64, rows: usize },
    #[error(
        "{file}: run {run} has {found} rows, expected {expected} as run {first}; cut the runs to the same \
         length, or diagnose them apart"
    )]
    RunLength { file: String, run: i64, found: usize, first: i64, expected: usize },
    #[error(
        "{file}: found {found} drives and {positions} positions, expected one of each for kind = \
         \"second-order\"; use kind = \"linear\" for several, or give one axis at a time"
    )]
    Channels { file: String, found: usize, positions: usize },
    #[error(
        "{file}: is sampled every {found} s, expected {expected} s as the recording {recording}; resample it \
         yourself or give a held-out recording of the same rate"
    )]
    Rate { file: String, found: f64, expected: f64, recording: String },
    #[error(
        "{file}: has {found}, expected {expected} as the recording {recording}; give one of the same device"
    )]
    OtherChannels { file: String, found: String, expected: String, recording: String },
    #[error(
        "{at}: the column `{column}`, which `feedback` in the plant names, is missing, found {found}; add \
         it, or drop `feedback` if the drive was not under feedback"
    )]
    Feedback { at: String, column: String, found: String },
    #[error("{file}: found {found}, expected {expected}; simulate exactly the rows of the recording")]
    Simulated { file: String, found: String, expected: String },
    #[error(
        "{file}: no second-order plant follows this drive (the best leaves {percent:.0} % of the position's \
         variance); check that `drive` and `position` belong together, or use kind = \"linear\""
    )]
    NoPlant { file: String, percent: f64 },
    #[error(
        "{file}: found {found} drives and {positions} positions, expected one position and as many drives as the plant has \
         inputs ({wanted}); give a recording of this plant, or correct its `inputs`"
    )]
    Inputs { file: String, wanted: usize, found: usize, positions: usize },
    #[error(
        "{file}: a simulation of one's own stands beside a plant in equations; state that simulation as equations instead"
    )]
    OwnSimulation { file: String },
    #[error(transparent)]
    Equations(#[from] motion::equations::EquationsError),
    #[error("{file}: effect `{id}`: {reason}")]
    Effect { file: String, id: String, reason: String },
}
