//! From a proved routine to files: the Rust crate, the C pair, the certificate.

use std::collections::BTreeMap;
use std::path::PathBuf;

use fitter::coefficients::Coefficients;
use fitter::terms::Operator;
use minijinja::{Value, context};

use super::choose::{TurnRoutine, entry_bytes};
use super::shape::{Arithmetic, Shape};
use super::wraps::Wraps;
use crate::accepted::accepted;
use crate::certificate::{Certificate, Entry, OutputEntry, Part, RangeEntry, inputs, rust_type};
use crate::claim::Claim;
use crate::estimate::NORMAL_95;
use crate::generate::{GenerateError, Generated, TOOL, sha256};
use crate::name;
use crate::options::{CShift, Options};
use crate::render::{Renderer, c_type, helpers, steps};
use crate::text;

/// The name unless one is given.
const NAME: &str = "corrected_counts";
/// Numbers in a line of a table of one column.
const NUMBERS_IN_A_LINE: usize = 16;

/// All files.
///
/// # Errors
/// [`GenerateError`]: a name that is no identifier, or a defect of a template.
pub fn files(
    routine: &TurnRoutine,
    coefficients: &Coefficients,
    coefficients_sha256: &str,
    options: &Options,
) -> Result<Generated, GenerateError> {
    let name = name::base(options, NAME)?;
    let renderer = Renderer::new()?;
    let provenance = renderer.provenance(coefficients, coefficients_sha256, options)?;
    let wraps = Wraps::of(coefficients)?;
    let entry = entry(routine, &name, coefficients, &wraps);
    let contract = contract(&renderer, routine, &entry, (coefficients, &wraps), options)?;
    let source = || source(routine, &name, &entry, options, &provenance, &contract);
    let mut files = BTreeMap::new();
    let bound_text = format!("{} {}", text::rounded_up(entry.bound), entry.unit);
    let listed = vec![context! { name => &*name, type_name => "", state => false, bound_text }];
    let krate = || {
        context! {
            tool => TOOL, name => &*name, description => "corrected counts of an encoder",
            provenance => &*provenance, routines => listed.clone(),
        }
    };
    files.insert(PathBuf::from("Cargo.toml"), renderer.render("rust/Cargo.toml", krate())?);
    files.insert(PathBuf::from("src/lib.rs"), renderer.render("rust/lib.rs", krate())?);
    for (path, template) in [
        (format!("src/{name}.rs"), "turn/routine.rs"),
        (format!("c/{name}.h"), "turn/header.h"),
        (format!("c/{name}.c"), "turn/source.c"),
    ] {
        files.insert(PathBuf::from(path), renderer.render(template, source())?);
    }
    let entries =
        [("rust", format!("src/{name}.rs")), ("c", format!("c/{name}.c"))].map(|(language, file)| {
            let file_sha256 = files.get(&PathBuf::from(&file)).map(|text| sha256(text)).unwrap_or_default();
            Entry { language: language.into(), file, file_sha256, ..entry.clone() }
        });
    let certificate = Certificate {
        schema: "arcsmith-certificate".into(),
        version: 1,
        tool: TOOL.into(),
        command: options.command.clone(),
        coefficients_sha256: coefficients_sha256.into(),
        recording: coefficients.recording.file.clone(),
        recording_sha256: coefficients.recording.sha256.clone(),
        reservation: accepted(coefficients, options)?,
        routines: entries.to_vec(),
    };
    files.insert(PathBuf::from("certificate.json"), serde_json::to_string_pretty(&certificate)? + "\n");
    Ok(Generated { name, files, certificate, routines: Vec::new(), unreachable: Vec::new() })
}

/// What the certificate says.
fn entry(routine: &TurnRoutine, name: &str, coefficients: &Coefficients, wraps: &Wraps) -> Entry {
    let (words, unit) = (routine.words, coefficients.sensor.error_unit().to_string());
    let (degree, format) = match routine.shape {
        Shape::PerCount => (0, format!("i{}", 8 * entry_bytes(&routine.filling))),
        Shape::Segments { degree, arithmetic: Arithmetic::Short, .. } => (degree, "i16".into()),
        Shape::Segments { degree, arithmetic: Arithmetic::Long, .. } => (degree, "q31".into()),
    };
    let bound = routine.bound();
    let rounding = bound.min(0.5 * routine.unit_per_count);
    let part =
        |what: &str, value: f64| Part { what: what.into(), value, lsb: value / routine.unit_per_count };
    Entry {
        routine: name.into(),
        language: String::new(),
        format,
        degree,
        segments: routine.shape.segments(words),
        unit: unit.clone(),
        input: inputs(&routine.program),
        output: OutputEntry {
            ty: rust_type(routine.program.output_type()).into(),
            lsb: routine.unit_per_count,
            fraction_bits: None,
            unit,
        },
        range: RangeEntry {
            variable: "count".into(),
            unit: "counts".into(),
            from: 0.0,
            to: f64::from(words.counts - 1),
            recorded: None,
        },
        out_of_range: if words.whole() { "modulo" } else { "clamp" }.into(),
        bound,
        parts: vec![
            part("rounding of the result to whole counts", rounding),
            part("interpolation, its coefficients and operations", bound - rounding),
        ],
        minimax: 0.0,
        input_resolution: routine.unit_per_count * f64::from(1u32 << words.finer),
        estimate: claim(coefficients, wraps),
        left_out: wraps.left_out.iter().map(ToString::to_string).collect(),
        file: String::new(),
        file_sha256: String::new(),
    }
}

/// How far the corrected position may be from the device's.
fn claim(coefficients: &Coefficients, wraps: &Wraps) -> Option<Claim> {
    let mut left_out: Vec<f64> = wraps.left_out.iter().filter_map(|out| out.size).collect();
    let directions = coefficients.turn.as_ref().and_then(|turn| turn.directions.half_distance.as_ref());
    let has_play = coefficients.terms.iter().any(|term| matches!(term.operator, Operator::Play(_)));
    // What the directions differ by stays uncorrected, too.
    left_out.extend(directions.filter(|_| !has_play).map(|half| half.value.abs()));
    Claim::of(coefficients, band(coefficients, wraps), &left_out)
}

/// The largest half-width of the 95 % band of constant and harmonics over the turn, in the sensor's unit; none where
/// some covariance is not known.
fn band(coefficients: &Coefficients, wraps: &Wraps) -> Option<f64> {
    const PLACES: u32 = 360;
    let all = coefficients.covariance_of_all()?;
    let revolution = coefficients.turn.as_ref()?.revolution;
    let mut largest = 0.0f64;
    for place in 0..PLACES {
        let position = revolution * f64::from(place) / f64::from(PLACES);
        // What is left out of the routine is left out of its band.
        let mut columns = vec![0.0; coefficients.base.coefficients.len()];
        if let Some(constant) = columns.first_mut() {
            *constant = 1.0;
        }
        for (index, term) in coefficients.terms.iter().enumerate() {
            match &term.operator {
                Operator::Periodic(p) if wraps.terms.contains(&index) => {
                    columns.extend(p.columns_at(position))
                }
                _ => columns.extend(std::iter::repeat_n(0.0, term.coefficients.len())),
            }
        }
        let row = |row: &Vec<f64>| row.iter().zip(&columns).map(|(v, b)| v * b).sum::<f64>();
        largest = largest.max(all.iter().zip(&columns).map(|(r, a)| a * row(r)).sum::<f64>());
    }
    Some(NORMAL_95 * largest.sqrt())
}

fn contract(
    renderer: &Renderer,
    routine: &TurnRoutine,
    entry: &Entry,
    (coefficients, wraps): (&Coefficients, &Wraps),
    options: &Options,
) -> Result<String, GenerateError> {
    let (words, unit) = (routine.words, &entry.unit);
    let waves = wraps.waves.iter().map(|(k, a, b)| format!("{a:+?}·cos({k}φ) {b:+?}·sin({k}φ)"));
    let waves: Vec<String> = waves.collect();
    let left_out = &entry.left_out;
    let claim = entry.estimate.as_ref().map(|claim| claim.in_words(unit));
    let directions = coefficients.turn.as_ref().map(|turn| turn.directions.statement.trim());
    let directions = directions.filter(|s| !s.is_empty()).unwrap_or("nothing is known of them");
    let parts: Vec<String> = (entry.parts.iter().filter(|part| part.value > 0.0))
        .map(|part| format!("{} {unit}   ({:.3} LSB)  {}", text::rounded_up(part.value), part.lsb, part.what))
        .collect();
    let context = context! {
        counts => words.counts,
        last => words.counts - 1,
        whole => words.whole(),
        zero_text => format!("{:?}", wraps.zero),
        assumed => options.encoder.assumes(coefficients),
        unit, waves, left_out, directions, parts,
        input_bits => words.input(),
        output_bits => words.output(),
        output_type => &*entry.output.ty,
        largest => words.result_counts() - 1,
        result_counts => words.result_counts(),
        method => method(routine),
        instructions => format!("{:.0}", routine.cost.instructions),
        core => routine.core.name(),
        bound_text => format!("{} {unit}", text::rounded_up(entry.bound)),
        bound_counts => text::rounded_up(routine.proof.bound),
        claim_text => claim.as_ref().map(|(figure, _)| figure.clone()),
        claim_parts => claim.map(|(_, parts)| parts).unwrap_or_default(),
    };
    Ok(renderer.render("turn/contract.txt", context)?)
}

/// The form in words.
pub fn method(routine: &TurnRoutine) -> String {
    let bytes = table_bytes(routine);
    match routine.shape {
        Shape::PerCount => {
            format!("a table of the correction of every count, {bytes} bytes")
        }
        Shape::Segments { degree, segments_log2: 0, .. } => {
            format!("one polynomial of degree {degree} for the whole turn")
        }
        Shape::Segments { degree, arithmetic, .. } => {
            let bits = if arithmetic == Arithmetic::Short { 16 } else { 32 };
            format!(
                "a table of {} polynomials of degree {degree}, {bits}-bit coefficients, {bytes} bytes",
                routine.shape.segments(routine.words)
            )
        }
    }
}

fn table_bytes(routine: &TurnRoutine) -> usize {
    let entries: usize = routine.program.table.iter().map(Vec::len).sum();
    let bytes = match routine.shape {
        Shape::PerCount => entry_bytes(&routine.filling),
        Shape::Segments { arithmetic: Arithmetic::Short, .. } => 2,
        Shape::Segments { .. } => 4,
    };
    bytes * entries
}

/// The table's lines: one for each row, or many numbers of one column in a line.
fn lines(table: &[Vec<i64>], number: &dyn Fn(i64) -> String, open: char, close: char) -> Vec<String> {
    let joined = |values: &mut dyn Iterator<Item = i64>| values.map(number).collect::<Vec<_>>().join(", ");
    if table.first().is_some_and(|row| row.len() == 1) {
        return (table.chunks(NUMBERS_IN_A_LINE))
            .map(|rows| joined(&mut rows.iter().flatten().copied()))
            .collect();
    }
    let padding = if open == '{' { " " } else { "" };
    let line =
        |row: &Vec<i64>| format!("{open}{padding}{}{padding}{close}", joined(&mut row.iter().copied()));
    table.iter().map(line).collect()
}

fn source(
    routine: &TurnRoutine,
    name: &str,
    entry: &Entry,
    options: &Options,
    provenance: &str,
    contract: &str,
) -> Value {
    let program = &routine.program;
    let entry_type = match table_bytes(routine) / program.table.iter().map(Vec::len).sum::<usize>().max(1) {
        1 => "i8",
        2 => "i16",
        _ => "i32",
    };
    let c_entry_type = format!("int{}_t", &entry_type[1..]);
    let all: Vec<usize> = (0..program.steps.len()).collect();
    // −2³¹ never stands in a table: coefficients are limited to ±(2³¹ − 1).
    let plain = |value: i64| value.to_string();
    let grouped = |value: i64| text::grouped(value);
    context! {
        name, provenance, contract,
        guard => format!("{}_H", name.to_uppercase()),
        input_type => rust_type(program.steps[0].ty),
        output_type => rust_type(program.output_type()),
        c_input_type => c_type(program.steps[0].ty),
        c_output_type => c_type(program.output_type()),
        input_bits => routine.words.input(),
        last => routine.words.counts - 1,
        whole => routine.words.whole(),
        result_counts => routine.words.result_counts(),
        bound_counts => text::rounded_up(entry.bound / routine.unit_per_count),
        arithmetic_shift => options.c_shift == CShift::Arithmetic,
        helpers => helpers(program, &all, options.c_shift).into_iter().filter(|name| *name != "mul_short").collect::<Vec<_>>(),
        steps => steps(program, &all),
        result_name => &*program.steps[program.output()].name,
        rows => program.table.len(),
        columns => program.table.first().map_or(0, Vec::len),
        table => lines(&program.table, &plain, '{', '}'),
        rust_table => lines(&program.table, &grouped, '[', ']'),
        entry_type, c_entry_type,
        table_comment => match routine.shape {
            Shape::PerCount => "What is added to every count",
            _ => "Coefficients of the polynomials, constant first, one row for each segment",
        },
    }
}
