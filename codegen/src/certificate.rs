//! The certificate: what is proved about every generated routine, for machines to read.

use fitter::budget::Budget;
use serde::{Deserialize, Serialize};

use crate::output::Output;
use crate::program::Program;
use crate::text;

/// The whole file, `certificate.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
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
    /// The uncertainty budget of each routine, whatever the language, and of each device that shares it; of those whose
    /// coefficients say what the recording showed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub budgets: Vec<OfRoutine>,
}

/// The uncertainty budget of a routine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OfRoutine {
    /// Name of the function.
    pub routine: String,
    /// The device with whose page it runs; none where the routine is of one device.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// The budget.
    pub budget: Budget,
}

/// One routine in one language.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Name of the function.
    pub routine: String,
    /// The language, as [`crate::language::Language::name`] has it; of a table, file and version of the firmware's source.
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
    /// A lower bound of the supremum error of any polynomial of this degree (a table: of any with its segments), whatever
    /// its coefficients; the best one's is more by less than a thousandth.
    pub minimax: f64,
    /// What one step of the input stands for, in `unit`; 0 for floats. Not part of the bound.
    pub input_resolution: f64,
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
    /// Its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Meaning and unit.
    pub meaning: String,
}

/// The result.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OutputEntry {
    /// Its type.
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
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
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

impl Certificate {
    /// The file.
    ///
    /// # Errors
    /// A defect of serialisation.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

impl Entry {
    /// What a program's types say of its arguments and its result, in words of `lsb`.
    pub fn of(name: &str, program: &Program, lsb: f64) -> Entry {
        let argument = |a: &crate::program::Argument| InputEntry {
            name: a.name.clone(),
            ty: a.ty.name().into(),
            meaning: a.meaning.clone(),
        };
        let ty = program.output_type().name().into();
        Entry {
            routine: name.into(),
            segments: 1,
            input: program.arguments.iter().map(argument).collect(),
            output: OutputEntry { ty, lsb, ..OutputEntry::default() },
            ..Entry::default()
        }
    }

    /// The sum of the parts, rounded up.
    pub fn sum(parts: &[Part]) -> f64 {
        parts.iter().fold(0.0, |sum: f64, p| (sum + p.value).next_up())
    }

    /// The parts that are not zero, for a head; `lsb` writes how many last places one is.
    pub fn parts_in_words(&self, lsb: impl Fn(f64) -> String) -> Vec<String> {
        let parts = self.parts.iter().filter(|part| part.value > 0.0);
        let value = |part: &Part| format!("{} {}", text::rounded_up(part.value), self.unit);
        parts.map(|part| format!("{} {}  {}", value(part), lsb(part.lsb), part.what)).collect()
    }

    /// What the result is, in words.
    pub fn result_meaning(&self, output: Output) -> String {
        let (unit, ty) = (&self.output.unit, &self.output.ty);
        match (output, self.output.fraction_bits) {
            (Output::PowerOfTwo, Some(bits)) => format!("`{ty}`, one unit is 2^−{bits} {unit}"),
            (Output::Nano, _) => format!("`{ty}`, one unit is 10⁻⁹ {unit}"),
            (Output::Micro, _) => format!("`{ty}`, one unit is 10⁻⁶ {unit}"),
            _ => format!("`{ty}`, in {unit}"),
        }
    }

    /// The range in words, with its ends in words of the reading.
    pub fn range_in_words(&self, program: &Program) -> String {
        let RangeEntry { variable, unit, from, to, .. } = &self.range;
        let words = match program.steps[program.reading].ty {
            crate::program::Type::F32 => String::new(),
            _ => {
                let [lo, hi] = [program.valid.0, program.valid.1].map(|word| text::grouped(word as i64));
                format!(", that is {lo} … {hi} in words of the input")
            }
        };
        format!("{from:?} {unit} ≤ {variable} ≤ {to:?} {unit}{words}")
    }
}
