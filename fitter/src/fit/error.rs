//! Why a recording cannot be fitted, and what a reader of a fit should know.

use thiserror::Error;

use crate::recording::Note;

/// Why a recording cannot be fitted.
#[derive(Debug, Error)]
pub enum FitError {
    #[error(
        "{file}: has the columns of {recording}, and the mirror file describes {mirror}; give the mirror file of \
         this sensor"
    )]
    OtherSensor { file: String, recording: &'static str, mirror: &'static str },
    #[error("{file}: has no reference, expected `{column}`; a fit needs the calibrated angle of every row")]
    NoReference { file: String, column: &'static str },
    #[error(
        "{file}, column `{column}`: found values that grow {slope:.4e} times as fast as {against}, expected about \
         as fast ({unit}){}",
        guess.map_or_else(|| String::from("; check the unit, or whether this is the right column"),
            |guess| format!("; they look like {guess}: convert them"))
    )]
    Unit {
        file: String,
        column: String,
        slope: f64,
        against: &'static str,
        unit: String,
        guess: Option<&'static str>,
    },
    #[error(
        "{file}, columns `x1_mm`, `x2_mm`: found a difference of up to {largest} mm with probes {distance_mm} mm \
         apart, expected a small part of that; are they micrometres? Convert them to mm"
    )]
    Displacement { file: String, largest: f64, distance_mm: f64 },
    #[error(
        "{file}, column `{column}`: falls where {against} grows (slope {slope:.3}), expected the same sense; \
         {mend}"
    )]
    Sense { file: String, column: String, slope: f64, against: &'static str, mend: &'static str },
    #[error(
        "{file}: all readings are at one angle ({from} to {to} {unit}), expected a calibration over a range of \
         angles; record several"
    )]
    OneAngle { file: String, from: f64, to: f64, unit: String },
    #[error(
        "{file}: found {points} distinct angles for the {parameters} parameters of order {order}, expected at least \
         {parameters}; record more angles or lower --order"
    )]
    TooFewPoints { file: String, points: usize, parameters: usize, order: usize },
    #[error(
        "{file}: found {points} readings to hold out by {grouping}, too few to choose an order by cross-validation; \
         record more angles or give --order"
    )]
    TooFewToHoldOut { file: String, points: usize, grouping: &'static str },
    #[error("--{option}: found {found}, expected {expected}; correct the option")]
    Option { option: &'static str, found: String, expected: &'static str },
    #[error("{rows} rows are too many for the trust region method (at most {most}); use --solver qr")]
    TooManyRows { rows: usize, most: usize },
    #[error("the trust region method did not converge ({reason}); use --solver qr")]
    NoConvergence { reason: String },
    #[error("the singular value decomposition did not converge; the recording's readings are degenerate")]
    Singular,
    #[error(
        "{file}: written in powers of the reading, order {order} loses {loss:.1e} rad, more than 1e-10 rad, because the \
         readings lie far from zero for their range; lower --order or record angles on both sides of zero"
    )]
    Conversion { file: String, order: usize, loss: f64 },
}

/// What a reader of a fit should know.
#[derive(Debug, Clone, PartialEq)]
pub enum FitNote {
    /// Noticed while reading.
    Reading(Note),
    /// There is one pass only.
    SinglePass,
    /// Several passes, but no angle that repeats.
    NothingRepeats,
    /// The recording has too little to score orders with; the user's stands.
    OrderGiven,
}

impl std::fmt::Display for FitNote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FitNote::Reading(note) => note.fmt(f),
            FitNote::SinglePass => {
                f.write_str("a single pass: no scatter between passes is known, intervals rest on the residuals")
            }
            FitNote::NothingRepeats => f.write_str(
                "no angle repeats between passes: the scatter is unknown, the order is chosen by contiguous blocks",
            ),
            FitNote::OrderGiven => f.write_str("too few angles to score other orders; the given one stands"),
        }
    }
}
