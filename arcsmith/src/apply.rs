//! `apply`.

use std::path::PathBuf;

use clap::Args;
use codegen::refused;
use fitter::recording::{Purpose, Reading};
use fitter::{acceptance, apply, coefficients, output};
use serde_json::json;

use crate::fit::{MapArgs, read, waiting};
use crate::terminal::{Common, FIGURE, Result, line, summarise, warn};
use codegen::cli::recording;

/// Arguments of `apply`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith apply scan.csv --coefficients coefficients.json --out angles.csv
  arcsmith apply log.csv --coefficients encoder.json --map measured=enc:14bit --strict")]
pub struct ApplyArgs {
    /// The recording (CSV, CSV.gz, or Parquet; `-`: standard input); it needs no reference
    #[arg(value_parser = recording())]
    recording: PathBuf,
    /// The coefficients, as `fit` or `diagnose` wrote them
    #[arg(long)]
    coefficients: PathBuf,
    /// Where to write the corrected angles (CSV)
    #[arg(long, default_value = "angles.csv")]
    out: PathBuf,
    #[command(flatten)]
    map: MapArgs,
    /// Refuse a recording that lacks a column which the coefficients depend on, instead of leaving the effect out
    #[arg(long)]
    strict: bool,
}

pub fn run(args: &ApplyArgs, common: Common) -> Result<()> {
    output::not_the_input(&args.out, &[&args.recording, &args.coefficients])?;
    let coefficients = coefficients::read(&args.coefficients)?;
    let usable = acceptance::to_apply(&coefficients);
    usable.map_err(|refusal| refused!("{refusal}").at(&args.coefficients).mend("fit again"))?;
    let reading =
        Reading { purpose: Purpose::Apply, mappings: &args.map.map, sensor: Some(&coefficients.sensor) };
    let recording = read(&args.recording, &reading, common)?;
    if args.strict {
        apply::check_columns(&recording, &coefficients)?;
    }
    let (file, rows) = (&recording.file, recording.rows());
    let applied = waiting("correcting", rows, common, || apply::apply_screened(&recording, &coefficients));
    let applied = applied?;
    let write = || apply::write(&args.out, &recording, &coefficients.sensor, &applied);
    waiting("writing", rows, common, write)?;
    for note in &applied.notes {
        warn(&note.to_string(), common);
    }
    let extrapolated = applied.extrapolated.iter().filter(|marked| **marked).count();
    let written = args.out.display().to_string();
    summarise(
        common,
        || {
            json!({
                "recording": file,
                "rows": rows,
                "extrapolated": extrapolated,
                "bad_rows": applied.bad_rows,
                "read": recording.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
                "warnings": applied.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
                "written": written,
            })
        },
        || {
            let mut text = format!("{file}: {FIGURE}{rows}{FIGURE:#} rows corrected, written {written}\n");
            for note in &recording.notes {
                text += &line("read", &note.to_string());
            }
            text
        },
    );
    Ok(())
}
