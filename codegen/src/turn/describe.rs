//! What certificate and heads say of the routine of an encoder.

use fitter::coefficients::Coefficients;
use fitter::terms::Operator;
use minijinja::context;

use super::TurnError;
use super::choose::TurnRoutine;
use super::shape::{Arithmetic, Shape};
use super::wraps::Wraps;
use crate::budget::{self, Known, quadratic};
use crate::certificate::{Entry, OutputEntry, Part, RangeEntry};
use crate::emit::{Described, OF_SEGMENTS};
use crate::options::Options;
use crate::text;

/// The name unless one is given.
pub const NAME: &str = "corrected_counts";

/// A proved routine with what is said of it.
///
/// # Errors
/// [`TurnError`] where the coefficients are of no whole turn.
pub fn described<'a>(
    routine: &'a TurnRoutine,
    name: &str,
    coefficients: &Coefficients,
    options: &Options,
) -> Result<Described<'a>, TurnError> {
    let wraps = Wraps::of(coefficients)?;
    let entry = entry(routine, name, coefficients, &wraps);
    let (words, whole) = (routine.words, routine.words.whole());
    let waves = wraps.waves.iter().map(|(k, a, b)| format!("{a:+?}·cos({k}φ) {b:+?}·sin({k}φ)"));
    let waves: Vec<String> = waves.collect();
    let directions = coefficients.turn.as_ref().map(|turn| turn.directions.statement.trim());
    let (bits, last) = (words.input(), words.counts - 1);
    let assumed = options.encoder.assumes(coefficients);
    let assumed = if assumed { " (as many as the noise asks for: none were named)" } else { "" };
    let input = if whole {
        format!("`count`: the encoder's word, {bits} bits{assumed}; higher bits are left out of account.")
    } else {
        format!("`count`: 0 … {last}; anything beyond is taken as the last count.")
    };
    let (ty, counts) = (&entry.output.ty, words.result_counts());
    let turn = context! {
        counts => words.counts,
        result_counts => counts,
        zero => format!("{:?}", wraps.zero),
        waves => if waves.is_empty() { vec!["none".into()] } else { waves },
        bound_counts => text::rounded_up(routine.proof.bound),
        instructions => format!("{:.0}", routine.cost.instructions),
        core => routine.core.name(),
        directions => directions.filter(|s| !s.is_empty()).unwrap_or("nothing is known of them"),
        input_bits => bits,
        whole, last,
    };
    let words = context! {
        turn,
        inputs => vec![input],
        result_meaning => format!("`{ty}`, {} bits, 0 … {}: {counts} to the turn", words.output(), counts - 1),
        range_text => "every count; the turn's end meets its beginning, for all arithmetic is modulo the turn",
        method => method(routine),
        parts => entry.parts_in_words(|lsb| format!("  ({lsb:.3} LSB)")),
        table_comment => match routine.shape {
            Shape::PerCount => "What is added to every count",
            Shape::Segments { .. } => OF_SEGMENTS,
        },
    };
    let budget = budget::of_turn(routine, coefficients, &wraps);
    Ok(Described { entry, budget, program: &routine.program, counts: true, words })
}

/// What the certificate says.
fn entry(routine: &TurnRoutine, name: &str, coefficients: &Coefficients, wraps: &Wraps) -> Entry {
    let (words, unit) = (routine.words, coefficients.sensor.error_unit().to_string());
    let (degree, format) = match routine.shape {
        Shape::PerCount => (0, format!("i{}", 8 * routine.program.entry_bytes())),
        Shape::Segments { degree, arithmetic: Arithmetic::Short, .. } => (degree, "i16".into()),
        Shape::Segments { degree, arithmetic: Arithmetic::Long, .. } => (degree, "q31".into()),
    };
    let bound = routine.bound();
    let rounding = bound.min(0.5 * routine.unit_per_count);
    let part =
        |what: &str, value: f64| Part { what: what.into(), value, lsb: value / routine.unit_per_count };
    let of_program = Entry::of(name, &routine.program, routine.unit_per_count);
    Entry {
        format,
        degree,
        segments: routine.shape.segments(words),
        unit: unit.clone(),
        output: OutputEntry { unit, ..of_program.output },
        range: RangeEntry {
            variable: "count".into(),
            unit: "counts".into(),
            to: f64::from(words.counts - 1),
            ..RangeEntry::default()
        },
        out_of_range: if words.whole() { "modulo" } else { "clamp" }.into(),
        bound,
        parts: vec![
            part("rounding of the result to whole counts", rounding),
            part("interpolation, its coefficients and operations", bound - rounding),
        ],
        input_resolution: routine.unit_per_count * f64::from(1u32 << words.finer),
        left_out: wraps.left_out.iter().map(ToString::to_string).collect(),
        ..of_program
    }
}

/// What a correction of the position alone leaves out, in words.
pub(crate) fn left_out(coefficients: &Coefficients, wraps: &Wraps) -> Vec<String> {
    let mut left_out: Vec<String> = wraps.left_out.iter().map(ToString::to_string).collect();
    let directions = coefficients.turn.as_ref().map(|turn| &turn.directions);
    let apart = directions.and_then(|directions| directions.half_distance.as_ref());
    if let Some(half) = apart.filter(|half| half.ci95[0] * half.ci95[1] > 0.0) {
        let unit = coefficients.sensor.error_unit();
        let value = half.value.abs();
        left_out.push(format!(
            "direction: a position alone does not tell from which side it was reached; it is {value:.2e} {unit} either way"
        ));
    }
    left_out
}

/// Half of the distance from backward to forward errors, where no term has it.
pub(crate) fn uncorrected_direction(coefficients: &Coefficients) -> Option<f64> {
    let has_play = coefficients.terms.iter().any(|term| matches!(term.operator, Operator::Play(_)));
    let half = coefficients.turn.as_ref()?.directions.half_distance.as_ref();
    half.filter(|_| !has_play).map(|half| half.value)
}

/// How well constant and harmonics are known at positions, in the sensor's unit; none where some covariance is not known.
pub(crate) fn known(coefficients: &Coefficients, wraps: &Wraps, positions: &[f64]) -> Option<Vec<Known>> {
    let all = coefficients.covariance_of_all()?;
    let at = |position: &f64| {
        // What is left out of the routine is left out of its interval.
        let mut columns = vec![0.0; coefficients.base.coefficients.len()];
        if let Some(constant) = columns.first_mut() {
            *constant = 1.0;
        }
        for (index, term) in coefficients.terms.iter().enumerate() {
            match &term.operator {
                Operator::Periodic(p) if wraps.terms.contains(&index) => {
                    columns.extend(p.columns_at(*position))
                }
                _ => columns.extend(std::iter::repeat_n(0.0, term.coefficients.len())),
            }
        }
        Known { rest: quadratic(&all, &columns).sqrt(), terms: Vec::new() }
    };
    Some(positions.iter().map(at).collect())
}

/// The form in words.
fn method(routine: &TurnRoutine) -> String {
    let bytes = routine.program.table_bytes();
    match routine.shape {
        Shape::PerCount => format!("a table of the correction of every count, {bytes} bytes"),
        Shape::Segments { degree, segments_log2: 0, .. } => {
            format!("one polynomial of degree {degree} for the whole turn")
        }
        Shape::Segments { degree, arithmetic, .. } => {
            let bits = if arithmetic == Arithmetic::Short { 16 } else { 32 };
            let segments = routine.shape.segments(routine.words);
            format!(
                "a table of {segments} polynomials of degree {degree}, {bits}-bit coefficients, {bytes} bytes"
            )
        }
    }
}
