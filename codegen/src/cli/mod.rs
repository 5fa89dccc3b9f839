//! The command line: arguments, and what is printed. [`main`] is the program, [`run`] its body for a program
//! that takes the same [`Command`]s in.

mod arguments;
mod encoder;
mod explore;
mod names;
mod options;
mod source;
mod units;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};
use fitter::cli::common::{FIGURE, WARNING, line, program, say, say_json, summarise, warn};
use fitter::coefficients::Coefficients;
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};
use serde::Serialize;
use serde_json::json;

use crate::accepted::accepted;
use crate::files;
use crate::generate::{Generated, generate};
use crate::language::ALL;
use crate::options::Options;
use crate::quantity::Quantity;
use crate::text;
use crate::verify::Checks;

pub use arguments::{Arguments, CheckArguments, ExploreArguments};

/// Generates the firmware correction of a scanning mirror, in Rust and C, with a proven error bound.
///
/// Generates from the coefficients that are named, or from the one file of them that lies in the folder.
#[derive(Debug, Parser)]
#[command(name = "codegen", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    arguments: Arguments,
}

/// Examples for the help of generation.
pub const EXAMPLES: &str = "\
Examples:
  codegen --demo --out firmware/demo
  codegen --coefficients coefficients.json --out firmware/angle --format q31 --input x1x2-counts \\
          --bits 16 --gain 1.2207e-5 --output nano
  codegen --recording slit.csv.gz --mirror slit.toml --bound 0.0001mm --out slit
  codegen check --coefficients coefficients.json --out firmware/angle";

/// The commands beside generation itself.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Compare what is in the output folder with what would be generated
    ///
    /// The exit code is 1 where the folder is stale; nothing is written.
    #[command(after_help = CHECK)]
    Check {
        /// How the files were generated.
        #[command(flatten)]
        arguments: Arguments,
        /// Also verify the certificate, and sweep the compiled Rust and C: what `verify` does without further options.
        #[arg(long)]
        sweep: bool,
    },
    /// List the Pareto-optimal routines (bound, instructions, flash) for every core
    #[command(after_help = EXPLORE)]
    Explore(ExploreArguments),
    /// Check the generated files from outside
    ///
    /// Recomputes the certificate and sweeps the compiled Rust and C against a bounded reference; the exit code
    /// is 1 where anything does not hold.
    #[command(after_help = VERIFY)]
    Verify {
        /// How the files were generated.
        #[command(flatten)]
        arguments: Arguments,
        /// What is checked.
        #[command(flatten)]
        checks: CheckArguments,
    },
}

const CHECK: &str = "\
Examples:
  codegen check --demo
  codegen check --coefficients coefficients.json --out firmware/angle --sweep";

const EXPLORE: &str = "\
Examples:
  codegen explore --demo --target cortex-m0
  codegen explore --coefficients coefficients.json --format q31,q15 --svg bounds.svg
  codegen explore --demo --json | jq '.[0]'";

const VERIFY: &str = "\
Examples:
  codegen verify --demo
  codegen verify --coefficients coefficients.json --out firmware/angle --exhaustive
  codegen verify --demo --gappa --frama-c --misra --sanitize --objects";

/// The program: parses the arguments, runs, and prints the message of what went wrong.
pub fn main() -> ExitCode {
    program(Cli::try_parse(), |cli| match cli.command {
        Some(command) => run(&command),
        None => generated(&cli.arguments),
    })
}

/// Runs a command; the exit code is 0, or 1 where something is stale or does not hold.
///
/// # Errors
/// Anything that is wrong with the input, in a sentence; nothing is written then.
pub fn run(command: &Command) -> Result<ExitCode> {
    let (Command::Check { arguments, .. }
    | Command::Explore(ExploreArguments { arguments, .. })
    | Command::Verify { arguments, .. }) = command;
    arguments.common.limit();
    match command {
        Command::Check { arguments, sweep: false } => check(arguments),
        Command::Check { arguments, sweep: true } => verify(arguments, &CheckArguments::default()),
        Command::Explore(arguments) => explore::explore(arguments),
        Command::Verify { arguments, checks } => verify(arguments, checks),
    }
}

/// Generates and writes, or compares where `--check` is given.
///
/// # Errors
/// As [`run`].
pub fn generated(arguments: &Arguments) -> Result<ExitCode> {
    arguments.common.limit();
    if arguments.check { check(arguments) } else { write(arguments) }
}

fn write(arguments: &Arguments) -> Result<ExitCode> {
    if !arguments.units.is_empty() {
        return units::write(arguments);
    }
    source::tell(arguments)?;
    let generated = prepare(arguments)?;
    let changed = files::write(&arguments.out, &generated.files).into_diagnostic()?;
    let (out, count) = (arguments.out.display().to_string(), generated.files.len());
    for missing in &generated.unreachable {
        warn(&format!("left out: {missing}"), arguments.common);
    }
    if let Some(open) = &generated.certificate.reservation {
        warn(open, arguments.common);
    }
    summarise(
        arguments.common,
        || {
            json!({
                "reservation": generated.certificate.reservation,
                "routines": generated.certificate.routines,
                "out": out,
                "files": generated.files.keys().collect::<Vec<_>>(),
                "changed": changed,
            })
        },
        || {
            summary(&generated, arguments.common.verbose)
                + &encoder::summary(&generated)
                + &estimated(&generated)
                + &line("written", &format!("{out}: {count} files, {changed} changed"))
        },
    );
    Ok(ExitCode::SUCCESS)
}

fn check(arguments: &Arguments) -> Result<ExitCode> {
    if !arguments.units.is_empty() {
        return stale(arguments, &units::prepare(arguments)?.files);
    }
    source::tell(arguments)?;
    stale(arguments, &prepare(arguments)?.files)
}

/// Compares files with those in the output folder.
fn stale<T: AsRef<[u8]>>(arguments: &Arguments, files: &BTreeMap<PathBuf, T>) -> Result<ExitCode> {
    let differences = files::compare(&arguments.out, files);
    let (out, count) = (&arguments.out, files.len());
    if arguments.common.json {
        let stale: Vec<_> = (differences.iter())
            .map(|(file, difference)| json!({"file": file, "difference": difference.to_string()}))
            .collect();
        say_json(&format!("{:#}", json!({"out": out, "files": count, "stale": stale})));
    } else if differences.is_empty() {
        if !arguments.common.quiet {
            say(&format!("{}: {count} files, {FIGURE}all up to date{FIGURE:#}", out.display()));
        }
    } else {
        for (file, difference) in &differences {
            say(&format!("{} {difference}", out.join(file).display()));
        }
        let stale = differences.len();
        say(&format!("{WARNING}{stale} of {count} files are stale{WARNING:#}: generate them again"));
    }
    Ok(if differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn verify(arguments: &Arguments, checks: &CheckArguments) -> Result<ExitCode> {
    if !arguments.units.is_empty() {
        return units::verify(arguments, checks);
    }
    source::tell(arguments)?;
    let (coefficients, sha256) = load(arguments)?;
    if coefficients.whole_turn() {
        return encoder::verify(arguments, checks, &coefficients, &sha256);
    }
    let (generated, quantity, options) = prepare_all(arguments)?;
    let bar = progress(arguments);
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent}% {per_sec} {eta}") {
        bar.set_style(style);
    }
    let wanted = Checks {
        exhaustive: checks.exhaustive,
        sanitize: checks.sanitize,
        gappa: checks.gappa,
        frama_c: checks.frama_c,
        misra: checks.misra,
        objects: checks.objects,
        mutants: checks.mutants,
    };
    let report = crate::verify::verify(&arguments.out, &generated, &quantity, &options, wanted, &bar)
        .map_err(|e| miette!("{e}"))?;
    bar.finish_and_clear();
    conclude(arguments, &report, report.holds(), &report.text())
}

/// Says what a verification found, and ends with 1 where something does not hold.
fn conclude(arguments: &Arguments, report: &impl Serialize, holds: bool, text: &str) -> Result<ExitCode> {
    if arguments.common.json {
        say_json(&serde_json::to_string_pretty(report).into_diagnostic()?);
    } else if !arguments.common.quiet || !holds {
        say(text.trim_end());
    }
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn prepare(arguments: &Arguments) -> Result<Generated> {
    Ok(prepare_all(arguments)?.0)
}

fn prepare_all(arguments: &Arguments) -> Result<(Generated, Quantity, Options)> {
    let bar = progress(arguments);
    let (coefficients, sha256) = load(arguments)?;
    if coefficients.whole_turn() {
        return encoder::prepare(arguments, &coefficients, &sha256);
    }
    options::no_encoder(arguments)?;
    let quantity = Quantity::of(&coefficients.error_model());
    let mut options = options::options(arguments, &quantity.bound_unit, !coefficients.terms.is_empty())?;
    if let Some(target) = arguments.target {
        explore::choose_for(target.core(), arguments, &coefficients, &mut options, &bar)?;
    }
    bar.set_message("approximating and bounding");
    let generated = generate(&coefficients, &sha256, &options).map_err(|e| miette!("{e}"))?;
    bar.finish_and_clear();
    Ok((generated, quantity, options))
}

/// Progress on standard error, where that is a terminal.
fn progress(arguments: &Arguments) -> ProgressBar {
    let bar = ProgressBar::hidden();
    if arguments.common.watched() {
        bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar.set_message("reading");
    bar
}

fn load(arguments: &Arguments) -> Result<(Coefficients, String)> {
    let (coefficients, sha256) = source::source(arguments)?.load().map_err(|e| miette!("{e}"))?;
    // Before anything else is said of what was asked for.
    let options = Options { accept_unexplained: arguments.accept_unexplained, ..Options::default() };
    accepted(&coefficients, &options).map_err(|e| miette!("{e}"))?;
    Ok((coefficients, sha256))
}

/// How far the model may be from the device, and what no routine of these has.
fn estimated(generated: &Generated) -> String {
    let Some(entry) = generated.certificate.routines.first() else { return String::new() };
    let claim = entry.estimate.as_ref().map(|claim| {
        let figure = format!("{} {}", text::rounded_up(claim.distance), entry.unit);
        line("estimate", &format!("the model is within {figure} of the device (not proved)"))
    });
    let left_out = entry.left_out.iter().map(|out| line("left out", out));
    claim.into_iter().chain(left_out).collect()
}

/// What was chosen and why, on one screen; `verbose` adds what every bound is made of.
fn summary(generated: &Generated, verbose: bool) -> String {
    let mut lines = String::new();
    for (routine, entry) in
        generated.routines.iter().zip(generated.certificate.routines.iter().step_by(ALL.len()))
    {
        let degree = routine.design.degree;
        let bound = format!("{} {}", text::rounded_up(entry.bound), entry.unit);
        lines += &format!(
            "{:<24} degree {degree:>2}   proven within {FIGURE}{bound}{FIGURE:#}   best of this degree {:.2e}\n",
            entry.routine, entry.minimax,
        );
        for part in entry.parts.iter().filter(|_| verbose) {
            lines += &line("", &format!("{:>10}  {}", text::rounded_up(part.value), part.what));
        }
    }
    lines
}
