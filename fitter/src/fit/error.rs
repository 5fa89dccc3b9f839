//! Why a recording cannot be fitted, and what a reader of a fit should know.

use thiserror::Error;

use crate::acceptance::Refusal;
use crate::recording::Note;

/// Why a recording cannot be fitted.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say what the fields are
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
    #[error(
        "{file}: found {points} distinct angles of the turn, which tell at most {most} harmonics, expected enough for \
         {harmonics}; record more angles, evenly, or lower --harmonics"
    )]
    TooFewForHarmonics { file: String, points: usize, harmonics: usize, most: usize },
    #[error(
        "{file}, line {line}: found measured {measured} and reference {reference}, {apart:.6} {unit} apart, expected \
         {low:.6} to {high:.6} {unit} as in the other rows{}; an average over readings on both sides of the \
         wrap-around gives such a row: read the angle once, or drop the row",
        if *others > 0 { format!(" ({others} more rows are like it)") } else { String::new() }
    )]
    TurnRow {
        file: String,
        line: u64,
        measured: f64,
        reference: f64,
        apart: f64,
        low: f64,
        high: f64,
        unit: String,
        others: usize,
    },
    #[error(
        "{file}, line {line}, column `{column}`: steps from {from} to {to}, which is no turn of {revolution} {unit}, \
         expected to wrap by `revolution`; it looks like {looks}: convert the column, or correct `revolution` in the \
         mirror file"
    )]
    TurnJump {
        file: String,
        line: u64,
        column: &'static str,
        from: f64,
        to: f64,
        revolution: f64,
        unit: String,
        looks: String,
    },
    #[error(
        "{file}, column `{column}`: found values that look like {looks}, expected {unit} with {revolution} in a turn; \
         convert them (--map does), or correct `revolution` in the mirror file"
    )]
    TurnUnit { file: String, column: &'static str, looks: String, revolution: f64, unit: String },
    #[error(
        "{file}: `measured` and `reference` have nothing in common within a turn of {revolution} {unit}, expected the \
         same angle but for an error of at most a quarter turn; check the columns and `revolution`"
    )]
    TurnUnrelated { file: String, revolution: f64, unit: String },
    #[error("--{option}: found {found}, expected {expected}; correct the option")]
    Option { option: &'static str, found: String, expected: &'static str },
    /// A model that [`to_apply`](crate::acceptance::to_apply) refuses is not handed out.
    #[error("{file}: {refusal}; check the units and the columns of the recording")]
    Unusable { file: String, refusal: Refusal },
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
#[allow(missing_docs)] // what the variants say of them
pub enum FitNote {
    /// Noticed while reading.
    Reading(Note),
    /// There is one pass only.
    SinglePass,
    /// Several passes, but no angle that repeats.
    NothingRepeats,
    /// A sensor that turns was recorded over a part of its turn.
    PartOfTurn { share: f64 },
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
            FitNote::PartOfTurn { share } => write!(
                f,
                "the readings cover {:.0} % of a turn: a polynomial was fitted to them, and nothing is known of the rest",
                100.0 * share
            ),
            FitNote::OrderGiven => f.write_str("too few angles to score other orders; the given one stands"),
        }
    }
}
