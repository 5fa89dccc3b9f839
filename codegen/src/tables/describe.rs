//! What file and certificate say of a table.

use std::collections::BTreeMap;
use std::path::PathBuf;

use fitter::budget::Budget;
use fitter::coefficients::Coefficients;
use minijinja::value::Serde;
use minijinja::{Value, context};

use super::{Table, TableError, TableFirmware};
use crate::budget;
use crate::certificate::{Certificate, Entry, InputEntry, OfRoutine, OutputEntry, Part, RangeEntry};
use crate::emit::Printer;
use crate::generate::{Generated, TOOL, sha256};
use crate::options::Options;
use crate::quantity::Quantity;
use crate::render::HEAD_COLUMNS;
use crate::text;

/// The parts of a bound: the best of the interpolation, what the entries as they are written make of it, both in exact
/// arithmetic, and the rest.
pub fn parts([best, written]: [f64; 2], bound: f64, lsb: f64) -> Vec<Part> {
    let (best, written) = (best.min(bound), written.min(bound));
    let part = |what: &str, value: f64| Part { what: what.into(), value, lsb: value / lsb };
    vec![
        part("interpolation between the entries, were they of unlimited precision", best.min(written)),
        part("rounding of the entries to the format", (written - best).max(0.0)),
        part("rounding of the firmware's operations, and of the proof", bound - written),
    ]
}

/// File and certificate.
///
/// # Errors
/// [`TableError`] of a template, or of a model that is not what the table was made of.
pub fn files(
    firmware: &dyn TableFirmware,
    table: &Table,
    coefficients: &Coefficients,
    coefficients_sha256: &str,
    reservation: Option<String>,
    options: &Options,
) -> Result<Generated, TableError> {
    let entry = entry(firmware, table, coefficients);
    let printer = Printer::new(&[], options)?;
    let recording = &coefficients.recording;
    let open =
        reservation.as_ref().map(|open| text::wrapped(&format!("UNEXPLAINED: {open}."), HEAD_COLUMNS, ""));
    let provenance = printer.provenance(
        context! { sha256 => coefficients_sha256, recording => Value::from(Serde(recording)), open },
    )?;
    let of_firmware =
        |budget: &Budget| OfRoutine { routine: entry.routine.clone(), device: None, budget: budget.clone() };
    let budgets = table.budget.iter().map(of_firmware).collect();
    let head = head(firmware, table, &entry, &provenance);
    let head = text::comment(&head, table.comment);
    let contents = match table.head_last {
        true => format!("{}{head}\n", table.text),
        false => format!("{head}\n{}", table.text),
    };
    let entry = Entry { file: table.file.into(), file_sha256: sha256(&contents), ..entry };
    let certificate = Certificate {
        schema: "arcsmith-certificate".into(),
        version: 1,
        tool: TOOL.into(),
        command: options.command.clone(),
        coefficients_sha256: coefficients_sha256.into(),
        recording: recording.file.clone(),
        recording_sha256: recording.sha256.clone(),
        reservation,
        routines: vec![entry],
        budgets,
    };
    let mut files = BTreeMap::from([(PathBuf::from(table.file), contents)]);
    files.insert(PathBuf::from("certificate.json"), certificate.to_json()?);
    Ok(Generated {
        name: firmware.name().into(),
        quantity: Quantity::of(&coefficients.error_model()),
        files,
        certificate,
        routines: Vec::new(),
        turn: None,
        unreachable: Vec::new(),
    })
}

/// What the certificate says.
fn entry(firmware: &dyn TableFirmware, table: &Table, coefficients: &Coefficients) -> Entry {
    let unit = coefficients.sensor.error_unit().to_string();
    let mut left_out = table.left_out.clone();
    left_out.insert(
        0,
        format!(
            "zero: the result is {:+?} {unit} above the reference everywhere; the firmware sets its zero elsewhere",
            table.zero
        ),
    );
    let (ty, lsb) = table.output;
    let (from, to, of) = &table.range;
    Entry {
        routine: firmware.name().into(),
        language: firmware.source().into(),
        format: table.format.into(),
        degree: table.degree,
        segments: table.entries,
        unit: unit.clone(),
        input: vec![InputEntry { name: of.clone(), ty: ty.into(), meaning: table.input.clone() }],
        output: OutputEntry { ty: ty.into(), lsb, fraction_bits: None, unit },
        range: RangeEntry { variable: of.clone(), unit: of.clone(), from: *from, to: *to, recorded: None },
        out_of_range: if coefficients.whole_turn() { "modulo" } else { "clamp" }.into(),
        bound: table.bound,
        parts: table.parts.clone(),
        minimax: table.minimax,
        input_resolution: coefficients.turn.as_ref().map_or(0.0, |turn| turn.revolution / (to - from + 1.0)),
        left_out,
        ..Entry::default()
    }
}

/// The head of the file.
fn head(firmware: &dyn TableFirmware, table: &Table, entry: &Entry, provenance: &str) -> String {
    let unit = &entry.unit;
    let figure = |value: f64| format!("{} {unit}", text::rounded_up(value));
    let mut head = format!("{}\n\n", provenance.trim_end());
    let mut say = |label: &str, content: &str| head += &format!("{label:<13} {content}\n");
    say("Firmware:", &format!("{}, as in {}", firmware.name(), firmware.source()));
    say("Table:", &format!("{} entries, {}", table.entries, table.format));
    say("Input:", &table.input);
    say(
        "Bound:",
        &format!("what the firmware computes is within {} of the model, proved", figure(entry.bound)),
    );
    for part in entry.parts_in_words(|_| String::new()) {
        say("", &part);
    }
    if let Some((expanded, lines)) = table.budget.as_ref().map(budget::in_words) {
        say("Budget:", &format!("U = {expanded} for 95 % (JCGM 100, no proof); where it is largest,"));
        say("", "the standard uncertainties are");
        lines.iter().for_each(|line| say("", line));
    }
    for out in &entry.left_out {
        say("Left out:", out);
    }
    for (index, line) in table.load.iter().enumerate() {
        say(if index == 0 { "Load:" } else { "" }, line);
    }
    head
}
