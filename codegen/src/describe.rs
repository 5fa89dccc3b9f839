//! What certificate and heads say of a routine of the reading: a polynomial or a table, with or without terms.

use fitter::coefficients::Coefficients;
use minijinja::context;

use crate::budget;
use crate::certificate::{Entry, OutputEntry, Part, RangeEntry};
use crate::emit::Described;
use crate::options::{Options, RoutineOptions};
use crate::output::Output;
use crate::program::Type;
use crate::quantity::Quantity;
use crate::routine::Routine;
use crate::text;

/// A designed routine with what is said of it.
pub fn described<'a>(
    routine: &'a Routine,
    name: &str,
    quantity: &Quantity,
    options: &Options,
    coefficients: &Coefficients,
) -> Described<'a> {
    let entry = entry(routine, name, quantity, options, coefficients);
    let (program, unit) = (&routine.design.program, &quantity.bound_unit);
    let variable = match routine.options.format.bits() {
        31 => "x/2³²",
        15 => "x/2¹⁶",
        _ => "x",
    };
    let method = match (routine.design.segments, routine.design.degree) {
        (1, degree) => {
            format!(
                "one polynomial of degree {degree} for the whole function, by Horner's scheme in {variable}"
            )
        }
        (segments, degree) => format!(
            "a table of {segments} polynomials of degree {degree}, {} bytes, the segment found by a shift",
            program.table_bytes()
        ),
    };
    let words = context! {
        title => &*quantity.title,
        formula => &*quantity.formula,
        symbol => &*quantity.symbol,
        terms => routine.physics.terms_in_words(),
        result_meaning => entry.result_meaning(routine.options.output),
        range_text => entry.range_in_words(program),
        extrapolated => entry.range.recorded.map(|(a, b)| format!("{a:?}…{b:?} {}", quantity.reading_unit)),
        line => routine.line,
        fixed => program.steps.iter().any(|s| s.ty == Type::I32),
        method,
        parts => entry.parts_in_words(|lsb| format!("{:>13}", format!("({lsb:.2} LSB)"))),
        best_text => best_text(&entry),
        resolution_text => (entry.input_resolution > 0.0)
            .then(|| format!("{} {unit}", text::rounded_up(entry.input_resolution))),
    };
    let budget = budget::of_routine(routine, quantity, coefficients);
    Described { entry, budget, program, counts: false, words }
}

/// How far the bound lies above what the degree can reach; nothing where a polynomial of it may be the function.
fn best_text(entry: &Entry) -> Option<String> {
    let of = match entry.segments {
        1 => "polynomial".into(),
        segments => format!("table of {segments} polynomials"),
    };
    let (degree, unit, ratio) = (entry.degree, &entry.unit, entry.bound / entry.minimax);
    let least = text::rounded_down(entry.minimax);
    (entry.minimax > 0.0).then(|| {
        format!(
            "No {of} of degree {degree} is nearer than {least} {unit}: the bound is {ratio:.2} times that."
        )
    })
}

/// What the certificate says.
fn entry(
    routine: &Routine,
    name: &str,
    quantity: &Quantity,
    options: &Options,
    coefficients: &Coefficients,
) -> Entry {
    let design = &routine.design;
    let bound = &design.bound;
    let largest = bound.output_range.0.abs().max(bound.output_range.1.abs());
    let word_unit = match design.program.output_type() {
        Type::F32 => f64::from((largest as f32).next_up() - largest as f32),
        _ => design.unit.to_f64(),
    };
    let part = |what: &str, value: f64| Part {
        what: what.into(),
        value: quantity.in_bound_unit(value),
        lsb: value / word_unit,
    };
    let approximation = bound.approximation.min(design.minimax);
    let mut parts = vec![
        part("best polynomial of this degree against the exact function", approximation),
        part("rounding of its coefficients to the format", bound.approximation - approximation),
        part("rounding of the input to the routine's variable", bound.input),
        part("rounding of the operations", bound.evaluation),
        part("rounding of the result to the output's format", bound.output),
    ];
    if !routine.physics.is_empty() {
        parts
            .push(part("terms of further physics, over the box of their inputs and all states", bound.terms));
    }
    let RoutineOptions { format, output, .. } = &routine.options;
    let power_of_two = format.is_fixed() && *output == Output::PowerOfTwo;
    let of_program = Entry::of(name, &design.program, design.unit.to_f64());
    Entry {
        format: format.name().into(),
        degree: design.degree,
        segments: design.segments,
        unit: quantity.bound_unit.clone(),
        output: OutputEntry {
            fraction_bits: power_of_two.then_some(design.sum_bits),
            unit: quantity.unit.clone(),
            ..of_program.output
        },
        range: RangeEntry {
            variable: quantity.reading.clone(),
            unit: quantity.reading_unit.clone(),
            from: routine.range.0,
            to: routine.range.1,
            recorded: routine.extrapolated(coefficients),
        },
        out_of_range: format!("{:?}", options.out_of_range).to_lowercase(),
        bound: Entry::sum(&parts).max(quantity.in_bound_unit(bound.total)),
        parts,
        minimax: quantity.in_bound_unit(design.minimax),
        input_resolution: quantity.in_bound_unit(routine.plan.resolution * routine.slope()),
        left_out: routine.physics.left_out.iter().map(ToString::to_string).collect(),
        ..of_program
    }
}
