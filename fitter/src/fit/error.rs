//! Why a recording cannot be fitted, and what a reader of a fit should know.

use crate::acceptance::Refusal;
use crate::recording::Note;

errors! {
    /// Why a recording cannot be fitted.
    #[derive(Debug)]
    pub enum FitError {
        OtherSensor { file: String, recording: &'static str, mirror: &'static str } =>
            at(file) says("has the columns of {recording}, and the mirror file describes {mirror}")
            mend("give the mirror file of this sensor");
        NoReference { file: String, column: &'static str } =>
            at(file) says("has no reference") expected("`{column}`")
            mend("a fit needs the calibrated angle of every row");
        Unit {
            file: String,
            column: String,
            slope: f64,
            against: &'static str,
            unit: String,
            guess: Option<&'static str>,
        } =>
            at(file) column(column) found("values that grow {slope:.4e} times as fast as {against}")
            expected("about as fast ({unit})")
            mend("{}", guess.map_or_else(|| String::from("check the unit, or whether this is the right column"),
                |guess| format!("they look like {guess}: convert them")));
        Displacement { file: String, largest: f64, distance_mm: f64 } =>
            at(file)
            found("a difference of up to {largest} mm between `x1_mm` and `x2_mm`, with probes {distance_mm} mm apart")
            expected("a small part of that") mend("are they micrometres? Convert them to mm");
        Sense { file: String, column: String, slope: f64, against: &'static str, mend: &'static str } =>
            at(file) column(column) says("falls where {against} grows (slope {slope:.3})")
            expected("the same sense") mend("{mend}");
        OneAngle { file: String, from: f64, to: f64, unit: String } =>
            at(file) says("all readings are at one angle ({from} to {to} {unit})")
            expected("a calibration over a range of angles") mend("record several");
        TooFewPoints { file: String, points: usize, parameters: usize, order: usize } =>
            at(file) found("{points} distinct angles for the {parameters} parameters of order {order}")
            expected("at least {parameters}") mend("record more angles or lower the order") by(order);
        TooFewToHoldOut { file: String, points: usize, grouping: &'static str } =>
            at(file)
            found("{points} readings to hold out by {grouping}, too few to choose an order by cross-validation")
            mend("record more angles or state the order") by(order);
        TooFewForHarmonics { file: String, points: usize, harmonics: usize, most: usize } =>
            at(file) found("{points} distinct angles of the turn, which tell at most {most} harmonics")
            expected("enough for {harmonics}") mend("record more angles, evenly, or ask for fewer harmonics")
            by(turn_harmonics);
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
        } =>
            at(file) line(line)
            found("measured {measured} and reference {reference}, {apart:.6} {unit} apart")
            expected("{low:.6} to {high:.6} {unit} as in the other rows{}",
                if *others > 0 { format!(" ({others} more rows are like it)") } else { String::new() })
            mend("an average over readings on both sides of the wrap-around gives such a row: read the angle \
                once, or drop the row");
        TurnJump {
            file: String,
            line: u64,
            column: &'static str,
            from: f64,
            to: f64,
            turn: String,
            looks: String,
        } =>
            at(file) line(line) column(column)
            says("steps from {from} to {to}, which is no turn of {turn}")
            expected("to wrap by `revolution`")
            mend("it looks like {looks}: convert the column, or correct `revolution` in the mirror file");
        TurnUnit { file: String, column: &'static str, looks: String, revolution: f64, unit: String } =>
            at(file) column(column) found("values that look like {looks}")
            expected("{unit} with {revolution} in a turn")
            mend("convert them as they are read, or correct `revolution` in the mirror file") by(map);
        TurnUnrelated { file: String, revolution: f64, unit: String } =>
            at(file)
            says("`measured` and `reference` have nothing in common within a turn of {revolution} {unit}")
            expected("the same angle but for an error of at most a quarter turn")
            mend("check the columns and `revolution`");
        Option { option: &'static str, found: String, expected: &'static str } =>
            found("{} {found}", option.replace('_', " ")) expected("{expected}") mend("correct it") by_name(option);
        Unusable { file: String, refusal: Refusal } =>
            at(file) says("{refusal}") mend("check the units and the columns of the recording");
        TooManyRows { rows: usize, most: usize } =>
            says("{rows} rows are too many for the trust region method (at most {most})")
            mend("use the solver qr") by(solver);
        NoConvergence { reason: String } =>
            says("the trust region method did not converge ({reason})") mend("use the solver qr") by(solver);
        Singular =>
            says("the singular value decomposition did not converge")
            mend("the recording's readings are degenerate");
        Conversion { file: String, order: usize, loss: f64 } =>
            at(file)
            says("written in powers of the reading, order {order} loses {loss:.1e} rad, more than 1e-10 rad, \
                because the readings lie far from zero for their range")
            mend("lower the order, or record angles on both sides of zero") by(order);
    }
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
