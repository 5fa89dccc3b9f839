//! From the shared structure to files: the Rust crate, the C pair, the pages, the certificate.

use std::collections::BTreeMap;
use std::path::PathBuf;

use minijinja::value::Serde;
use minijinja::{Value, context};
use serde::{Deserialize, Serialize};

use super::page::{HEAD_WORDS, MAGIC, Page, VERSION, intel_hex};
use super::structure::{Design, Fitted, Shared};
use super::{Device, DevicesError, Generated, Wanted};
use crate::accepted::accepted;
use crate::budget;
use crate::certificate::{Certificate, Entry, OfRoutine, OutputEntry, Part, RangeEntry};
use crate::emit::{Described, Printer};
use crate::generate::{GenerateError, TOOL, sha256};
use crate::language;
use crate::name;
use crate::options::Options;
use crate::output::Output;
use crate::program::PageWord;
use crate::render::HEAD_COLUMNS;
use crate::text;

/// What is proved of a unit is told in so many parts of the result's unit.
const PARTS_OF_A_UNIT: f64 = 256.0;

/// The shared structure and the units for machines to read, `units.json`. Of an earlier one only what the structure is
/// made of is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Summary {
    pub schema: String,
    pub version: u32,
    #[serde(skip_deserializing)]
    tool: String,
    pub structure: u32,
    pub degree: usize,
    pub fraction_bits: i64,
    /// Smallest and largest reading.
    pub range: [f64; 2],
    /// The bound in the result's unit.
    pub total: f64,
    /// Unit of bounds and rounding.
    #[serde(skip_deserializing)]
    unit: String,
    #[serde(skip_deserializing)]
    bound: f64,
    /// For any coefficients inside their ranges.
    #[serde(skip_deserializing)]
    rounding: f64,
    pub coefficients: Vec<PageWord>,
    #[serde(skip_deserializing)]
    units: Vec<OfUnit>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct OfUnit {
    unit: String,
    coefficients_sha256: String,
    recording: String,
    page: String,
    bound: f64,
    words: Vec<i64>,
}

/// What is proved of a device, as it stands in its page: rounded up.
fn proved(design: &Design, total: f64) -> u32 {
    (PARTS_OF_A_UNIT * (total / design.unit.to_f64()).next_up()).ceil() as u32
}

/// The page of a device.
pub fn page(design: &Design, device: &Device, fitted: &Fitted) -> Page {
    Page {
        structure: design.structure(),
        proved: proved(design, fitted.total),
        origin: device.sha256.get(..8).and_then(|digits| u32::from_str_radix(digits, 16).ok()).unwrap_or(0),
        coefficients: fitted.words.iter().map(|word| *word as i32).collect(),
    }
}

/// The devices' pages, as they go to flash and as Intel HEX.
fn of_pages(design: &Design, devices: &[Device], wanted: &Wanted) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for (device, fitted) in devices.iter().zip(&design.fitted) {
        let bytes = page(design, device, fitted).bytes();
        let hex = intel_hex(&bytes, wanted.address).into_bytes();
        files.insert(PathBuf::from(format!("pages/{}.hex", device.name)), hex);
        files.insert(PathBuf::from(format!("pages/{}.bin", device.name)), bytes);
    }
    files
}

/// The pages alone, for a routine that is there already.
///
/// # Errors
/// [`DevicesError`] for a defect of a template.
pub fn pages(
    design: Design,
    devices: &[Device],
    options: &Options,
    wanted: &Wanted,
) -> Result<Generated, DevicesError> {
    let name = options.name.clone().unwrap_or_else(|| design.shared.quantity.default_name.clone());
    let files = of_pages(&design, devices, wanted);
    let described = [described(&design, &name, Vec::new(), &[])];
    let printer = Printer::new(&language::ALL, options)?;
    let origin = Certificate { budgets: budgets(&design, devices, &name), ..origin(devices, options) };
    let certificate = printer.certificate(&name, origin, &described, &files);
    Ok(Generated { name, files, certificate, design })
}

/// All files.
///
/// # Errors
/// [`DevicesError`]: a name that is no identifier, or a defect of a template.
pub fn files(
    design: Design,
    devices: &[Device],
    options: &Options,
    wanted: &Wanted,
) -> Result<Generated, DevicesError> {
    let name = name::base(options, &design.shared.quantity.default_name)?;
    let printer = Printer::new(&language::ALL, options)?;
    let budgets = budgets(&design, devices, &name);
    let listed: Vec<Value> = (devices.iter().zip(&design.fitted))
        .map(|(device, fitted)| {
            let open = reserved(device, options).map(|open| text::wrapped(&open, HEAD_COLUMNS, "    "));
            context! {
                name => &*device.name, sha256 => &*device.sha256, open,
                bound_text => bound_text(&design, fitted.total),
            }
        })
        .collect();
    let provenance = printer.provenance(context! { units => listed.clone() })?;
    let described = [described(&design, &name, listed, &budgets)];
    let sources = printer.sources((&name, &design.shared.quantity.title), &provenance, &described)?;
    let mut files: BTreeMap<PathBuf, Vec<u8>> = of_pages(&design, devices, wanted);
    files.extend(sources.into_iter().map(|(path, text)| (path, text.into_bytes())));
    let summary = serde_json::to_string_pretty(&summary(&design, devices)).map_err(GenerateError::Json)?;
    files.insert(PathBuf::from("units.json"), (summary + "\n").into_bytes());
    let origin = Certificate { budgets, ..origin(devices, options) };
    let certificate = printer.certificate(&name, origin, &described, &files);
    let text = certificate.to_json().map_err(GenerateError::Json)?;
    files.insert(PathBuf::from("certificate.json"), text.into_bytes());
    Ok(Generated { name, files, certificate, design })
}

/// What the diagnosis of a unit left open, where it was to be taken all the same.
fn reserved(device: &Device, options: &Options) -> Option<String> {
    accepted(&device.coefficients, options).ok().flatten()
}

/// The budget of every device whose coefficients say what its recording showed.
fn budgets(design: &Design, devices: &[Device], name: &str) -> Vec<OfRoutine> {
    let of = |(device, fitted): (&Device, &Fitted)| {
        let budget = budget::of_page(&design.shared, fitted.total, &device.coefficients)?;
        Some(OfRoutine { routine: name.into(), device: Some(device.name.clone()), budget })
    };
    devices.iter().zip(&design.fitted).filter_map(of).collect()
}

/// A budget in a line: how large the expanded uncertainty is, and what is missing.
fn in_short(of: &OfRoutine) -> String {
    let missing = of.budget.missing.iter().map(|missing| format!("; MISSING: {missing}"));
    let device = of.device.iter().map(|device| format!("{device}: "));
    let (device, missing) = (device.collect::<String>(), missing.collect::<String>());
    format!("{device}U = {}{missing}", budget::in_words(&of.budget).0)
}

fn bound_text(design: &Design, value: f64) -> String {
    let quantity = &design.shared.quantity;
    format!("{} {}", text::rounded_up(quantity.in_bound_unit(value)), quantity.bound_unit)
}

fn summary(design: &Design, devices: &[Device]) -> Summary {
    let Shared { quantity, range, .. } = &design.shared;
    let in_bound_unit = |value| quantity.in_bound_unit(value);
    Summary {
        schema: "arcsmith-units".into(),
        version: 1,
        tool: TOOL.into(),
        structure: design.structure(),
        degree: design.degree,
        fraction_bits: design.bits,
        range: [range.0, range.1],
        total: design.total,
        unit: quantity.bound_unit.clone(),
        bound: in_bound_unit(design.total),
        rounding: in_bound_unit(design.rounding),
        coefficients: design.program.page.clone(),
        units: (devices.iter().zip(&design.fitted))
            .map(|(device, fitted)| OfUnit {
                unit: device.name.clone(),
                coefficients_sha256: device.sha256.clone(),
                recording: device.coefficients.recording.file.clone(),
                page: format!("pages/{}.bin", device.name),
                bound: in_bound_unit(fitted.total),
                words: fitted.words.clone(),
            })
            .collect(),
    }
}

/// The routine with what is said of it; `devices` are the devices as the heads list them.
fn described<'a>(
    design: &'a Design,
    name: &str,
    devices: Vec<Value>,
    budgets: &[OfRoutine],
) -> Described<'a> {
    let (program, quantity) = (&design.program, &design.shared.quantity);
    let entry = entry(design, name);
    let page = context! {
        units => devices,
        budgets => budgets.iter().map(in_short).collect::<Vec<_>>(),
        ranges => Value::from(Serde(&program.page)),
        length => Page::length(program.page.len()),
        head_words => HEAD_WORDS,
        magic => MAGIC,
        version => VERSION,
        structure => design.structure(),
        most_proved => proved(design, design.total),
        rounding_text => bound_text(design, design.rounding),
    };
    let method = format!(
        "one polynomial of degree {}, its coefficients words of 2^−{} {}, by Horner's scheme in x/2³²",
        design.degree, design.bits, quantity.unit
    );
    let words = context! {
        page, method,
        title => &*quantity.title,
        result_meaning => entry.result_meaning(design.shared.options.output),
        range_text => entry.range_in_words(program),
        bound_text => bound_text(design, design.total),
        float_input => false,
    };
    Described { entry, budget: None, program, counts: false, words }
}

/// What the certificate says of the routine: the bound of the device that is furthest, and the margin of later ones.
fn entry(design: &Design, name: &str) -> Entry {
    let quantity = &design.shared.quantity;
    let lsb = design.unit.to_f64();
    let part = |what: &str, value: f64| Part {
        what: what.into(),
        value: quantity.in_bound_unit(value),
        lsb: value / lsb,
    };
    let largest = |of: &dyn Fn(&Fitted) -> f64| design.fitted.iter().map(of).fold(0.0, f64::max);
    let mut parts = vec![
        part(
            "polynomial of a unit against its exact function, the largest of the units",
            largest(&|f| f.approximation),
        ),
        part("rounding of the input to the routine's variable", largest(&|f| f.input)),
        part("rounding of the operations, for any coefficients in their ranges", design.rounding),
    ];
    let left = quantity.in_bound_unit(design.total) - Entry::sum(&parts);
    if left > 0.0 {
        parts.push(part("margin for later devices", left / quantity.bound_units_per_unit));
    }
    let of_program = Entry::of(name, &design.program, lsb);
    let power_of_two = design.shared.options.output == Output::PowerOfTwo;
    Entry {
        format: design.shared.options.format.name().into(),
        degree: design.degree,
        unit: quantity.bound_unit.clone(),
        output: OutputEntry {
            fraction_bits: power_of_two.then_some(design.bits),
            unit: quantity.unit.clone(),
            ..of_program.output
        },
        range: RangeEntry {
            variable: quantity.reading.clone(),
            unit: quantity.reading_unit.clone(),
            from: design.shared.range.0,
            to: design.shared.range.1,
            recorded: None,
        },
        out_of_range: "clamp".into(),
        bound: Entry::sum(&parts).max(quantity.in_bound_unit(design.total)),
        parts,
        minimax: quantity.in_bound_unit(largest(&|f| f.approximation)),
        ..of_program
    }
}

/// Where the devices come from.
fn origin(devices: &[Device], options: &Options) -> Certificate {
    let hashes: Vec<&str> = devices.iter().map(|device| device.sha256.as_str()).collect();
    let recordings = || devices.iter().map(|device| &device.coefficients.recording);
    let said = |device: &Device| Some(format!("{}: {}", device.name, reserved(device, options)?));
    let open: Vec<String> = devices.iter().filter_map(said).collect();
    Certificate {
        coefficients_sha256: sha256(hashes.join("\n")),
        recording: recordings().map(|r| r.file.as_str()).collect::<Vec<_>>().join(", "),
        recording_sha256: sha256(recordings().map(|r| r.sha256.as_str()).collect::<Vec<_>>().join("\n")),
        reservation: (!open.is_empty()).then(|| open.join("\n")),
        ..Certificate::default()
    }
}
