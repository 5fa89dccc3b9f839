//! The command line of `fitter`.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};
use fitter::recording::Purpose;
use fitter::{Fitted, Mirror, Options, Recording, Solver, output};
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result};

/// Fits the angular error model of a scanning mirror to calibration recordings, and applies it.
#[derive(Parser)]
#[command(version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Choose the order, identify the coefficients, write coefficients.json
    Fit(FitArgs),
    /// Write the corrected reading of every row of a recording
    Apply(ApplyArgs),
}

#[derive(Args)]
struct ApplyArgs {
    /// The recording (CSV, or CSV.gz); it needs no reference
    recording: PathBuf,
    /// The coefficients, as `fitter fit` or `diagnose` wrote them
    #[arg(long)]
    coefficients: PathBuf,
    /// Where to write the corrected angles (CSV)
    #[arg(long, default_value = "angles.csv")]
    out: PathBuf,
}

#[derive(Args)]
struct FitArgs {
    /// The calibration recording (CSV, or CSV.gz)
    recording: PathBuf,
    /// The nominal mirror (mirror.toml)
    #[arg(long)]
    mirror: PathBuf,
    /// Where to write the coefficients
    #[arg(long, default_value = "coefficients.json")]
    out: PathBuf,
    /// Use this order instead of choosing one by cross-validation
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=15))]
    order: Option<u8>,
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

fn finite(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("found `{text}`, expected a finite number of millimetres")),
    }
}

pub fn run(cli: Cli) -> Result<()> {
    match cli.command {
        Command::Fit(args) => fit(&args),
        Command::Apply(args) => apply(&args),
    }
}

fn apply(args: &ApplyArgs) -> Result<()> {
    output::not_the_input(&args.out, &[&args.recording, &args.coefficients]).into_diagnostic()?;
    let coefficients = fitter::coefficients::read(&args.coefficients).into_diagnostic()?;
    let recording = read(&args.recording, Purpose::Apply)?;
    let applied = waiting("correcting", recording.rows(), || fitter::apply(&recording, &coefficients));
    let applied = applied.into_diagnostic()?;
    let write = || fitter::apply::write(&args.out, &recording, &coefficients.sensor, &applied);
    waiting("writing", recording.rows(), write).into_diagnostic()?;
    for note in &applied.notes {
        eprintln!("warning: {note}");
    }
    let (file, rows) = (&recording.file, recording.rows());
    say(&format!("{file}: {rows} rows corrected, written {}", args.out.display()));
    Ok(())
}

fn fit(args: &FitArgs) -> Result<()> {
    output::not_the_input(&args.out, &[&args.recording, &args.mirror]).into_diagnostic()?;
    let mirror = Mirror::read(&args.mirror).into_diagnostic()?;
    let recording = read(&args.recording, Purpose::Fit)?;
    let options = Options {
        order: args.order.map(usize::from),
        splits: fitter::order::Splits {
            count: args.splits as usize,
            held_out_share: f64::from(args.held_out_percent) / 100.0,
            seed: args.seed,
        },
        solver: match args.solver {
            SolverArg::Qr => Solver::Qr,
            SolverArg::TrustRegion => Solver::TrustRegion,
        },
        fitted: if args.average { Fitted::Averages } else { Fitted::Rows },
        probe_distance_error_mm: args.probe_distance_error,
        command: command_line(),
        ..Options::default()
    };
    let fit = waiting("fitting", recording.rows(), || fitter::fit(&recording, &mirror, &options))
        .into_diagnostic()?;
    let text = fit.coefficients.to_sealed_json();
    output::write_whole(&args.out, |file| file.write_all(text.as_bytes())).into_diagnostic()?;
    say(&format!("{}written      {}", fitter::summary::summary(&fit), args.out.display()));
    Ok(())
}

/// Shows that something goes on while a long recording is worked on, if someone is watching.
fn waiting<T>(what: &'static str, rows: usize, work: impl FnOnce() -> T) -> T {
    const LONG: usize = 500_000;
    if rows < LONG || !std::io::stderr().is_terminal() {
        return work();
    }
    let spinner = ProgressBar::new_spinner().with_message(format!("{what} {rows} rows"));
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    let result = work();
    spinner.finish_and_clear();
    result
}

/// Prints a line or several. That nobody reads them to the end (`| head`) is no error.
fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Reads a recording; a long one with a progress bar, if someone is watching.
fn read(path: &Path, purpose: Purpose) -> Result<Recording> {
    const LONG: u64 = 20 << 20;
    let bytes = path.metadata().map_or(0, |data| data.len());
    if bytes < LONG || !std::io::stderr().is_terminal() {
        return Recording::read_for(path, purpose, &mut |_| {}).into_diagnostic();
    }
    let bar = ProgressBar::new(bytes);
    if let Ok(style) = ProgressStyle::with_template("reading {bar:40} {bytes}/{total_bytes} {eta}") {
        bar.set_style(style);
    }
    let recording = Recording::read_for(path, purpose, &mut |read| bar.set_position(read));
    bar.finish_and_clear();
    recording.into_diagnostic()
}

/// The command as it was typed, with the program's name alone in place of its path.
fn command_line() -> String {
    let quoted = |argument: String| {
        let plain = |sign: char| sign.is_alphanumeric() || "-_./=:+,".contains(sign);
        if !argument.is_empty() && argument.chars().all(plain) {
            argument
        } else {
            format!("'{}'", argument.replace('\'', "'\\''"))
        }
    };
    std::iter::once("fitter".to_string())
        .chain(std::env::args_os().skip(1).map(|argument| quoted(argument.to_string_lossy().into_owned())))
        .collect::<Vec<_>>()
        .join(" ")
}
