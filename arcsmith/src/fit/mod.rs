//! `fit`, and the options of every command that fits.

mod progress;
pub mod summary;

use std::borrow::Cow;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fitter::faults::{self, Screened};
use fitter::recording::{Mapping, Purpose, Reading};
use fitter::text_safety::shell_word;
use fitter::{Fit, Fitted, Mirror, Options, Recording, Sensor, Solver, order, output, text_safety};
use serde_json::json;

use crate::terminal::{self, Common, Result, line, summarise};
use codegen::cli::recording;
pub use progress::{read, waiting};

/// Arguments of `fit`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith fit calibration.csv --mirror mirror.toml
  arcsmith fit calibration.csv.gz --mirror mirror.toml --order 9 --out mirror-12.json
  arcsmith fit export.csv --mirror mirror.toml --map x1_mm=Probe1:um --map x2_mm=Probe2:um \\
      --map reference_arcsec=Autocollimator:urad
  arcsmith fit encoder.csv --mirror encoder.toml --json | jq .harmonics")]
pub struct FitArgs {
    /// The calibration recording (CSV, CSV.gz, or Parquet; `-`: standard input)
    #[arg(value_parser = recording())]
    recording: PathBuf,
    /// Where to write the coefficients
    #[arg(long, default_value = "coefficients.json")]
    out: PathBuf,
    #[command(flatten)]
    model: ModelArgs,
}

/// Columns under other names.
#[derive(Args, Debug, Clone, Default)]
pub struct MapArgs {
    /// A column under another name, in another unit: `x1_mm=Probe1:um`, `measured=enc:14bit`
    #[arg(long = "map", value_name = "NAME=COLUMN[:UNIT]")]
    pub map: Vec<Mapping>,
}

impl MapArgs {
    /// As they are typed.
    pub fn typed(&self) -> String {
        self.map.iter().map(|mapping| format!(" --map {}", shell_word(&mapping.to_string()))).collect()
    }
}

/// The options of a fit, for every command that fits.
#[derive(Args)]
pub struct ModelArgs {
    /// The nominal mirror or sensor (mirror.toml; `arcsmith init` writes one)
    #[arg(long)]
    pub mirror: PathBuf,
    #[command(flatten)]
    map: MapArgs,
    /// Use this order instead of choosing one by cross-validation
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=15))]
    order: Option<u8>,
    /// Of a sensor that turns: use so many harmonics of the turn instead of choosing by cross-validation
    #[arg(
        long,
        visible_alias = "turn-harmonics",
        value_parser = clap::value_parser!(u8).range(0..=32),
        conflicts_with = "order"
    )]
    harmonics: Option<u8>,
    /// Number of repeated splits of the cross-validation
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    splits: u32,
    /// Share of the angles that each split holds out, in per cent
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u8).range(5..=50))]
    held_out_percent: u8,
    /// Seed of the splits
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How the least-squares problem is solved
    #[arg(long, value_enum, default_value_t = SolverArg::Qr)]
    solver: SolverArg,
    /// Fit the averages over passes (Eq. 7) instead of all rows
    #[arg(long)]
    average: bool,
    /// The probe distance error Δd in mm, measured elsewhere; it frees a1
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = finite)]
    probe_distance_error: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum SolverArg {
    /// Householder QR in an orthonormal basis
    Qr,
    /// The paper's trust region method
    TrustRegion,
}

fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("found `{text}`, expected a finite number of millimetres")),
    }
}

impl ModelArgs {
    fn options(&self) -> Options {
        Options {
            order: self.order.map(usize::from),
            harmonics: self.harmonics.map(usize::from),
            splits: order::Splits {
                count: self.splits as usize,
                held_out_share: f64::from(self.held_out_percent) / 100.0,
                seed: self.seed,
            },
            solver: match self.solver {
                SolverArg::Qr => Solver::Qr,
                SolverArg::TrustRegion => Solver::TrustRegion,
            },
            fitted: if self.average { Fitted::Averages } else { Fitted::Rows },
            probe_distance_error_mm: self.probe_distance_error,
            command: command_line(),
            ..Options::default()
        }
    }

    /// Reads mirror and recording, leaves out what cannot be readings, and fits the rest.
    pub fn fit(&self, path: &std::path::Path, common: Common) -> Result<(Screened<'static>, Fit)> {
        let mirror = Mirror::read(&self.mirror)?;
        let reading =
            Reading { purpose: Purpose::Fit, mappings: &self.map.map, sensor: Some(&mirror.sensor) };
        let recording = read(path, &reading, common)?;
        let options = self.options();
        let screened = faults::screen(Cow::Owned(recording), &mirror.sensor)?;
        let recording = &*screened.recording;
        let fit = waiting("fitting", recording.rows(), common, || fitter::fit(recording, &mirror, &options))?;
        Ok((screened, fit))
    }

    /// The options that depart from their defaults, as they are typed; `--mirror` and `--map` stand apart.
    pub fn typed(&self) -> String {
        let usual = Options::default().splits;
        let percent = (100.0 * usual.held_out_share).round() as u8;
        let given = [
            self.order.map(|order| format!("--order {order}")),
            self.harmonics.map(|count| format!("--harmonics {count}")),
            (self.splits as usize != usual.count).then(|| format!("--splits {}", self.splits)),
            (self.held_out_percent != percent)
                .then(|| format!("--held-out-percent {}", self.held_out_percent)),
            (self.seed != usual.seed).then(|| format!("--seed {}", self.seed)),
            matches!(self.solver, SolverArg::TrustRegion).then(|| "--solver trust-region".to_string()),
            self.average.then(|| "--average".to_string()),
            self.probe_distance_error.map(|mm| format!("--probe-distance-error {mm}")),
        ];
        given.into_iter().flatten().map(|option| format!(" {option}")).collect()
    }

    /// The mapped columns, as they are typed.
    pub fn typed_map(&self) -> String {
        self.map.typed()
    }

    /// As a further recording of the same sensor is read.
    pub fn read_other(&self, path: &std::path::Path, sensor: &Sensor, common: Common) -> Result<Recording> {
        let reading = Reading { purpose: Purpose::Fit, mappings: &self.map.map, sensor: Some(sensor) };
        let recording = read(path, &reading, common)?;
        Ok(faults::screen(Cow::Owned(recording), sensor)?.recording.into_owned())
    }
}

pub fn run(args: &FitArgs, common: Common) -> Result<()> {
    let (screened, fit) = args.model.fit(&args.recording, common)?;
    let text = fit.coefficients.to_sealed_json();
    output::not_the_input(&args.out, &[&args.recording, &args.model.mirror])?;
    output::write_whole(&args.out, |file| file.write_all(text.as_bytes()))?;
    let written = args.out.display().to_string();
    summarise(
        common,
        || {
            let mut value = summary::json(&fit);
            value["bad_rows"] = json!(screened.bad_rows);
            value["findings"] = json!(screened.notes);
            value["written"] = json!(written);
            value
        },
        || {
            summary::styled(&fit, common.verbose)
                + &summary::left_out(&screened.bad_rows, &screened.notes, common.verbose)
                + &line("written", &written)
        },
    );
    Ok(())
}

/// The command as it was typed, or as the project has it, with the program's name alone in place of its path.
pub fn command_line() -> String {
    let words: Vec<String> = std::iter::once("arcsmith".to_string())
        .chain(terminal::words().iter().map(|word| shell_word(word)))
        .collect();
    text_safety::command(&words.join(" "))
}
