//! `fitter apply`.

use std::path::PathBuf;

use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use serde_json::json;

use super::progress::{read, waiting};
use super::{Common, MapArgs, summarise, warn};
use crate::output;
use crate::recording::{Purpose, Reading};
use crate::summary::{FIGURE, line};
use crate::text_safety;

/// Arguments of `fitter apply`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  fitter apply scan.csv --coefficients coefficients.json --out angles.csv
  fitter apply log.csv --coefficients encoder.json --map measured=enc:14bit --strict")]
pub struct ApplyArgs {
    /// The recording (CSV, CSV.gz, or Parquet); it needs no reference
    recording: PathBuf,
    /// The coefficients, as `fitter fit` or `diagnose` wrote them
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

pub(super) fn run(args: &ApplyArgs, common: Common) -> Result<()> {
    output::not_the_input(&args.out, &[&args.recording, &args.coefficients]).into_diagnostic()?;
    let coefficients = crate::coefficients::read(&args.coefficients).into_diagnostic()?;
    let usable = crate::acceptance::to_apply(&coefficients);
    usable.map_err(|refusal| miette!("{}: {refusal}; fit again", text_safety::path(&args.coefficients)))?;
    let reading =
        Reading { purpose: Purpose::Apply, mappings: &args.map.map, sensor: Some(&coefficients.sensor) };
    let recording = read(&args.recording, &reading, common)?;
    if args.strict {
        crate::apply::check_columns(&recording, &coefficients).into_diagnostic()?;
    }
    let (file, rows) = (&recording.file, recording.rows());
    let applied = waiting("correcting", rows, common, || crate::apply_screened(&recording, &coefficients));
    let applied = applied.into_diagnostic()?;
    let write = || crate::apply::write(&args.out, &recording, &coefficients.sensor, &applied);
    waiting("writing", rows, common, write).into_diagnostic()?;
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
