//! From the shared structure to files: the Rust crate, the C pair, the pages, the certificate.

use std::collections::BTreeMap;
use std::path::PathBuf;

use minijinja::value::Serde;
use minijinja::{Value, context};
use serde::Serialize;

use super::page::{HEAD_WORDS, MAGIC, Page, VERSION, intel_hex};
use super::structure::{Design, Fitted};
use super::{Generated, Unit, UnitsError, Wanted};
use crate::accepted::accepted;
use crate::certificate::{
    Certificate, Entry, OutputEntry, Part, RangeEntry, inputs, result_meaning, rust_type,
};
use crate::generate::{GenerateError, TOOL, sha256};
use crate::name;
use crate::options::{CShift, Options};
use crate::program::Type;
use crate::render::{HEAD_COLUMNS, Renderer, c_type, helpers, steps};
use crate::text;

/// What is proved of a unit is told in so many parts of the result's unit.
const PARTS_OF_A_UNIT: f64 = 256.0;

/// The shared structure and the units for machines to read, `units.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Summary<'a> {
    schema: &'static str,
    version: u32,
    tool: &'static str,
    structure: u32,
    degree: usize,
    fraction_bits: i64,
    /// Smallest and largest reading.
    range: [f64; 2],
    /// The bound in the result's unit.
    total: f64,
    /// Unit of bounds and rounding.
    unit: &'a str,
    bound: f64,
    /// For any coefficients inside their ranges.
    rounding: f64,
    coefficients: Vec<RangeOfWords<'a>>,
    units: Vec<OfUnit<'a>>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct RangeOfWords<'a> {
    name: &'a str,
    from: i64,
    to: i64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct OfUnit<'a> {
    unit: &'a str,
    coefficients_sha256: &'a str,
    recording: &'a str,
    page: String,
    bound: f64,
    words: &'a [i64],
}

/// What is proved of a unit, as it stands in its page: rounded up.
fn proved(design: &Design, total: f64) -> u32 {
    (PARTS_OF_A_UNIT * (total / design.unit.to_f64()).next_up()).ceil() as u32
}

/// The page of a unit.
pub fn page(design: &Design, unit: &Unit, fitted: &Fitted) -> Page {
    Page {
        structure: design.structure,
        proved: proved(design, fitted.total),
        origin: unit.sha256.get(..8).and_then(|digits| u32::from_str_radix(digits, 16).ok()).unwrap_or(0),
        coefficients: fitted.words.iter().map(|word| *word as i32).collect(),
    }
}

/// The units' pages, as they go to flash and as Intel HEX.
fn of_pages(design: &Design, units: &[Unit], wanted: &Wanted) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for (unit, fitted) in units.iter().zip(&design.fitted) {
        let bytes = page(design, unit, fitted).bytes();
        let hex = intel_hex(&bytes, wanted.address).into_bytes();
        files.insert(PathBuf::from(format!("pages/{}.hex", unit.name)), hex);
        files.insert(PathBuf::from(format!("pages/{}.bin", unit.name)), bytes);
    }
    files
}

/// The pages alone, for a routine that is there already.
pub fn pages(design: Design, units: &[Unit], options: &Options, wanted: &Wanted) -> Generated {
    let name = options.name.clone().unwrap_or_else(|| design.quantity.default_name.clone());
    let files = of_pages(&design, units, wanted);
    let certificate = certificate(units, &files, &name, entry(&design, &name), options);
    Generated { name, files, certificate, design }
}

/// All files.
///
/// # Errors
/// [`UnitsError`]: a name that is no identifier, or a defect of a template.
pub fn files(
    design: Design,
    units: &[Unit],
    options: &Options,
    wanted: &Wanted,
) -> Result<Generated, UnitsError> {
    let name = name::base(options, &design.quantity.default_name)?;
    let renderer = Renderer::new()?;
    let of_units: Vec<Value> = (units.iter().zip(&design.fitted))
        .map(|(unit, fitted)| {
            let open = reserved(unit, options).map(|open| text::wrapped(&open, HEAD_COLUMNS, "    "));
            context! {
                name => &*unit.name, sha256 => &*unit.sha256, open,
                bound_text => bound_text(&design, fitted.total),
            }
        })
        .collect();
    let provenance = renderer.render(
        "units/provenance.txt",
        context! { tool => TOOL, command => &*options.command, units => of_units.clone() },
    )?;
    let entry = entry(&design, &name);
    let source = source(&renderer, &design, &entry, of_units, options, &provenance)?;
    let mut files: BTreeMap<PathBuf, Vec<u8>> = BTreeMap::new();
    for (path, template) in [
        ("Cargo.toml".to_string(), "rust/Cargo.toml"),
        ("src/lib.rs".to_string(), "units/lib.rs"),
        (format!("src/{name}.rs"), "units/routine.rs"),
        (format!("c/{name}.h"), "units/header.h"),
        (format!("c/{name}.c"), "units/source.c"),
    ] {
        files.insert(PathBuf::from(path), renderer.render(template, source.clone())?.into_bytes());
    }
    files.extend(of_pages(&design, units, wanted));
    let json = |error| UnitsError::Generate(GenerateError::Json(error));
    let summary = serde_json::to_string_pretty(&summary(&design, units)).map_err(json)? + "\n";
    files.insert(PathBuf::from("units.json"), summary.into_bytes());
    let certificate = certificate(units, &files, &name, entry, options);
    let text = serde_json::to_string_pretty(&certificate).map_err(json)? + "\n";
    files.insert(PathBuf::from("certificate.json"), text.into_bytes());
    Ok(Generated { name, files, certificate, design })
}

/// What the diagnosis of a unit left open, where it was to be taken all the same.
fn reserved(unit: &Unit, options: &Options) -> Option<String> {
    accepted(&unit.coefficients, options).ok().flatten()
}

fn bound_text(design: &Design, value: f64) -> String {
    let quantity = &design.quantity;
    format!("{} {}", text::rounded_up(quantity.in_bound_unit(value)), quantity.bound_unit)
}

fn summary<'a>(design: &'a Design, units: &'a [Unit]) -> Summary<'a> {
    let in_bound_unit = |value| design.quantity.in_bound_unit(value);
    Summary {
        schema: "arcsmith-units",
        version: 1,
        tool: TOOL,
        structure: design.structure,
        degree: design.degree,
        fraction_bits: design.bits,
        range: [design.range.0, design.range.1],
        total: design.total,
        unit: &design.quantity.bound_unit,
        bound: in_bound_unit(design.total),
        rounding: in_bound_unit(design.rounding),
        coefficients: (design.program.page.iter())
            .map(|word| RangeOfWords { name: &word.name, from: word.from, to: word.to })
            .collect(),
        units: (units.iter().zip(&design.fitted))
            .map(|(unit, fitted)| OfUnit {
                unit: &unit.name,
                coefficients_sha256: &unit.sha256,
                recording: &unit.coefficients.recording.file,
                page: format!("pages/{}.bin", unit.name),
                bound: in_bound_unit(fitted.total),
                words: &fitted.words,
            })
            .collect(),
    }
}

/// What the certificate says of the routine: the bound of the unit that is furthest, and the margin of later ones.
fn entry(design: &Design, name: &str) -> Entry {
    let quantity = &design.quantity;
    let lsb = design.unit.to_f64();
    let part = |what: &str, value: f64| Part {
        what: what.into(),
        value: quantity.in_bound_unit(value),
        lsb: value / lsb,
    };
    let largest = |of: &dyn Fn(&Fitted) -> f64| design.fitted.iter().map(of).fold(0.0, f64::max);
    let parts = vec![
        part(
            "polynomial of a unit against its exact function, the largest of the units",
            largest(&|f| f.approximation),
        ),
        part("rounding of the input to the routine's variable", largest(&|f| f.input)),
        part("rounding of the operations, for any coefficients in their ranges", design.rounding),
    ];
    let mut parts = parts;
    let sum = parts.iter().fold(0.0, |sum: f64, p| (sum + p.value).next_up());
    let left = quantity.in_bound_unit(design.total) - sum;
    if left > 0.0 {
        parts.push(part("margin for later units", left / quantity.bound_units_per_unit));
    }
    let sum = parts.iter().fold(0.0, |sum: f64, p| (sum + p.value).next_up());
    Entry {
        routine: name.into(),
        language: String::new(),
        format: design.options.format.name().into(),
        degree: design.degree,
        segments: 1,
        unit: quantity.bound_unit.clone(),
        input: inputs(&design.program),
        output: OutputEntry {
            ty: rust_type(design.program.output_type()).into(),
            lsb,
            fraction_bits: (design.options.output == crate::output::Output::PowerOfTwo)
                .then_some(design.bits),
            unit: quantity.unit.clone(),
        },
        range: RangeEntry {
            variable: quantity.reading.clone(),
            unit: quantity.reading_unit.clone(),
            from: design.range.0,
            to: design.range.1,
            recorded: None,
        },
        out_of_range: "clamp".into(),
        bound: sum.max(quantity.in_bound_unit(design.total)),
        parts,
        minimax: quantity.in_bound_unit(largest(&|f| f.approximation)),
        input_resolution: 0.0,
        estimate: None,
        left_out: Vec::new(),
        file: String::new(),
        file_sha256: String::new(),
    }
}

fn certificate(
    units: &[Unit],
    files: &BTreeMap<PathBuf, Vec<u8>>,
    name: &str,
    entry: Entry,
    options: &Options,
) -> Certificate {
    let hashes: Vec<&str> = units.iter().map(|unit| unit.sha256.as_str()).collect();
    let recordings: Vec<&str> = units.iter().map(|unit| unit.coefficients.recording.file.as_str()).collect();
    let of_recordings: Vec<&str> =
        units.iter().map(|unit| unit.coefficients.recording.sha256.as_str()).collect();
    let said = |unit: &Unit| Some(format!("{}: {}", unit.name, reserved(unit, options)?));
    let open: Vec<String> = units.iter().filter_map(said).collect();
    let routines = [("rust", format!("src/{name}.rs")), ("c", format!("c/{name}.c"))];
    let routines = routines.map(|(language, file)| {
        let contents = files.get(&PathBuf::from(&file));
        let file_sha256 = contents.map(|b| sha256(&String::from_utf8_lossy(b))).unwrap_or_default();
        Entry { language: language.into(), file, file_sha256, ..entry.clone() }
    });
    Certificate {
        schema: "arcsmith-certificate".into(),
        version: 1,
        tool: TOOL.into(),
        command: options.command.clone(),
        coefficients_sha256: sha256(&hashes.join("\n")),
        recording: recordings.join(", "),
        recording_sha256: sha256(&of_recordings.join("\n")),
        reservation: (!open.is_empty()).then(|| open.join("\n")),
        routines: routines.to_vec(),
    }
}

fn source(
    renderer: &Renderer,
    design: &Design,
    entry: &Entry,
    units: Vec<Value>,
    options: &Options,
    provenance: &str,
) -> Result<Value, UnitsError> {
    let (program, quantity) = (&design.program, &design.quantity);
    let name = &entry.routine;
    let all: Vec<usize> = (0..program.steps.len()).collect();
    let mut used = helpers(program, &all, options.c_shift);
    used.push("to_signed");
    let arguments: Vec<Value> = (program.arguments.iter())
        .map(|a| context! { name => &*a.name, meaning => &*a.meaning, type => rust_type(a.ty), c_type => c_type(a.ty) })
        .collect();
    let coefficients: Vec<Value> = (program.page.iter())
        .map(|word| {
            let (from, to) = (word.from, word.to);
            context! { name => &*word.name, from, to, from_text => text::grouped(from), to_text => text::grouped(to) }
        })
        .collect();
    let words = match program.steps[program.reading].ty {
        Type::F32 => String::new(),
        _ => {
            let [lo, hi] = [program.valid.0, program.valid.1].map(|word| text::grouped(word as i64));
            format!(", that is {lo} … {hi} in words of the input")
        }
    };
    let (from, to) = design.range;
    let reading = &quantity.reading;
    let context = context! {
        tool => TOOL, provenance, units, arguments, coefficients,
        name => &**name,
        description => &*quantity.title,
        header => format!("{name}.h"),
        guard => format!("{}_H", name.to_uppercase()),
        upper => name.to_uppercase(),
        type_name => text::camel_case(name),
        quantity => Value::from(Serde(quantity)),
        result_meaning => result_meaning(entry, design.options.output),
        range_text => format!("{from:?} {0} ≤ {reading} ≤ {to:?} {0}{words}", quantity.reading_unit),
        degree => design.degree,
        bits => design.bits,
        length => Page::length(program.page.len()),
        head_words => HEAD_WORDS,
        magic => MAGIC,
        version => VERSION,
        structure => design.structure,
        most_proved => proved(design, design.total),
        bound_text => bound_text(design, design.total),
        rounding_text => bound_text(design, design.rounding),
        resolution_text => Option::<String>::None,
        steps => steps(program, &all),
        result_name => &*program.steps[program.output()].name,
        output_type => rust_type(program.output_type()),
        c_output_type => c_type(program.output_type()),
        helpers => used.clone(),
        routine => context! { helpers => used },
        uses_fmaf => false,
        arithmetic_shift => options.c_shift == CShift::Arithmetic,
    };
    let contract = renderer.render("units/contract.txt", context.clone())?;
    Ok(context! { contract, ..context })
}
