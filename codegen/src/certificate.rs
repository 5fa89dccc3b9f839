//! The certificate: what is proved about every generated routine, for machines to read.

use serde::{Deserialize, Serialize};

use fitter::coefficients::Coefficients;

use crate::claim::Claim;
use crate::estimate;
use crate::options::Options;
use crate::output::Output;
use crate::program::{Program, Type};
use crate::quantity::Quantity;
use crate::routine::Routine;

/// The whole file, `certificate.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// Always `arcsmith-certificate`.
    pub schema: String,
    /// Version of the schema.
    pub version: u32,
    /// Program and version.
    pub tool: String,
    /// The command that reproduces the files.
    pub command: String,
    /// SHA-256 of the coefficients.
    pub coefficients_sha256: String,
    /// The recording that the coefficients were fitted to.
    pub recording: String,
    /// Its SHA-256.
    pub recording_sha256: String,
    /// What the diagnosis of the recording left open, where that is more than it named: the model corrects the device
    /// in part only, and was taken all the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reservation: Option<String>,
    /// One entry for each routine and language.
    pub routines: Vec<Entry>,
}

/// One routine in one language.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Name of the function.
    pub routine: String,
    /// `rust` or `c`.
    pub language: String,
    /// Number format of the evaluation.
    pub format: String,
    /// Degree of the polynomial, or of each of the table's.
    pub degree: usize,
    /// Number of polynomials in the table; 1 without one.
    pub segments: usize,
    /// Unit of `bound` and of the parts.
    pub unit: String,
    /// What the routine is given.
    pub input: Vec<InputEntry>,
    /// What it returns.
    pub output: OutputEntry,
    /// The readings for which the bound holds.
    pub range: RangeEntry,
    /// Outside the range.
    pub out_of_range: String,
    /// |result − exact result| is at most this for every input in the range, output rounding included.
    pub bound: f64,
    /// What the bound is made of; the values sum up to it.
    pub parts: Vec<Part>,
    /// Supremum error of the best polynomial of this degree, before its coefficients were rounded.
    pub minimax: f64,
    /// What one step of the input stands for, in `unit`; 0 for floats. Not part of the bound.
    pub input_resolution: f64,
    /// Not proved, but estimated: how far the model itself may be from the device, in `unit`; none where the file does
    /// not say what the recording showed.
    #[serde(default)]
    pub estimate: Option<Claim>,
    /// Terms of the coefficients that the routine does not have, with their size.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// The file that holds the routine, relative to the certificate.
    pub file: String,
    /// SHA-256 of that file.
    pub file_sha256: String,
}

/// An argument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InputEntry {
    /// Its name.
    pub name: String,
    /// Its type, in Rust's words.
    #[serde(rename = "type")]
    pub ty: String,
    /// Meaning and unit.
    pub meaning: String,
}

/// The result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutputEntry {
    /// Its type, in Rust's words.
    #[serde(rename = "type")]
    pub ty: String,
    /// What one unit of an integer stands for in `unit`; for a float 1.
    pub lsb: f64,
    /// Fractional bits, where one unit stands for a power of two.
    pub fraction_bits: Option<i64>,
    /// The unit, `rad` for an angle.
    pub unit: String,
}

/// A range of readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RangeEntry {
    /// `s` or `m`.
    pub variable: String,
    /// Its unit.
    pub unit: String,
    /// Smallest reading.
    pub from: f64,
    /// Largest reading.
    pub to: f64,
    /// What the recording covers, where the range goes beyond.
    pub recorded: Option<(f64, f64)>,
}

/// A part of the bound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// What it is.
    pub what: String,
    /// How much, in the entry's unit.
    pub value: f64,
    /// The same in units of the result's last place (for a float: of the largest result).
    pub lsb: f64,
}

/// What the certificate and the head of a file say of a routine, before it is rendered.
pub fn entry(
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
    Entry {
        routine: name.into(),
        language: String::new(),
        format: routine.options.format.name().into(),
        degree: design.degree,
        segments: design.segments,
        unit: quantity.bound_unit.clone(),
        input: inputs(&design.program),
        output: OutputEntry {
            ty: rust_type(design.program.output_type()).into(),
            lsb: design.unit.to_f64(),
            fraction_bits: design.fraction_bits,
            unit: quantity.unit.clone(),
        },
        range: RangeEntry {
            variable: quantity.reading.clone(),
            unit: quantity.reading_unit.clone(),
            from: routine.range.0,
            to: routine.range.1,
            recorded: routine.extrapolated(coefficients),
        },
        out_of_range: format!("{:?}", options.out_of_range).to_lowercase(),
        bound: parts
            .iter()
            .fold(0.0, |sum: f64, p| (sum + p.value).next_up())
            .max(quantity.in_bound_unit(bound.total)),
        parts,
        minimax: quantity.in_bound_unit(design.minimax),
        input_resolution: quantity.in_bound_unit(routine.plan.resolution * routine.slope()),
        estimate: claim(routine, quantity, coefficients),
        left_out: routine.physics.left_out.iter().map(ToString::to_string).collect(),
        file: String::new(),
        file_sha256: String::new(),
    }
}

/// How far the model may be from the device; nothing is known of it where nothing was recorded.
fn claim(routine: &Routine, quantity: &Quantity, coefficients: &Coefficients) -> Option<Claim> {
    if routine.line {
        return None;
    }
    let band = estimate::band(coefficients, &routine.physics, quantity, routine.range);
    let left_out: Vec<f64> = routine.physics.left_out.iter().filter_map(|out| out.size).collect();
    Claim::of(coefficients, band, &left_out)
}

/// The inputs of a program, in the order of its arguments.
pub fn inputs(program: &Program) -> Vec<InputEntry> {
    let entry = |a: &crate::program::Argument| InputEntry {
        name: a.name.clone(),
        ty: rust_type(a.ty).into(),
        meaning: a.meaning.clone(),
    };
    program.arguments.iter().map(entry).collect()
}

/// A type in Rust's words.
pub fn rust_type(ty: Type) -> &'static str {
    match ty {
        Type::U16 => "u16",
        Type::U32 => "u32",
        Type::I32 => "i32",
        Type::I64 => "i64",
        Type::F32 => "f32",
    }
}

/// What the result is, in words.
pub fn result_meaning(entry: &Entry, output: Output) -> String {
    let unit = &entry.output.unit;
    let ty = &entry.output.ty;
    match (output, entry.output.fraction_bits) {
        (Output::PowerOfTwo, Some(bits)) => format!("`{ty}`, one unit is 2^−{bits} {unit}"),
        (Output::Nano, _) => format!("`{ty}`, one unit is 10⁻⁹ {unit}"),
        (Output::Micro, _) => format!("`{ty}`, one unit is 10⁻⁶ {unit}"),
        _ => format!("`{ty}`, in {unit}"),
    }
}
