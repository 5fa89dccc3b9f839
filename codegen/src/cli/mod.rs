//! The command line: arguments, and what is printed.

mod arguments;
mod explore;
mod names;
mod options;

use std::io::IsTerminal;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};
use fitter::coefficients::Coefficients;
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};

use crate::files;
use crate::generate::{Generated, generate};
use crate::options::Options;
use crate::quantity::Quantity;
use crate::source::Source;
use crate::text;
use crate::verify::Checks;

use arguments::{Arguments, CheckArguments, ExploreArguments};

/// Generates the firmware correction of a scanning mirror, in Rust and C, with a proven error bound.
///
/// Without arguments, the embedded recording is fitted and `generated/` written.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    arguments: Arguments,
}

const EXAMPLES: &str = "Examples:
  codegen
  codegen --coefficients coefficients.json --out firmware/angle --format q31 --input x1x2-counts \\
          --bits 16 --gain 1.2207e-5 --output nano
  codegen --recording slit.csv.gz --mirror slit.toml --bound 0.0001mm --out slit
  codegen check --coefficients coefficients.json --out firmware/angle";

#[derive(Debug, Subcommand)]
enum Command {
    /// Compares what is in the output folder with what would be generated; exit code 1 where it is stale.
    Check(Arguments),
    /// Lists the routines that no other beats in bound, instructions and flash, for every core.
    Explore(ExploreArguments),
    /// Checks the generated files from outside: recomputes the certificate and sweeps the compiled Rust and C
    /// against a bounded reference; exit code 1 where anything does not hold.
    Verify {
        #[command(flatten)]
        arguments: Arguments,
        #[command(flatten)]
        checks: CheckArguments,
    },
}

/// Runs the program; the exit code is 0, or 1 where `check` found something stale.
///
/// # Errors
/// Anything that is wrong with the input, in a sentence; nothing is written then.
pub fn run(cli: Cli) -> Result<ExitCode> {
    match cli.command {
        Some(Command::Check(arguments)) => check(&arguments),
        Some(Command::Explore(arguments)) => explore::explore(&arguments),
        Some(Command::Verify { arguments, checks }) => verify(&arguments, &checks),
        None if cli.arguments.check => check(&cli.arguments),
        None => write(&cli.arguments),
    }
}

fn write(arguments: &Arguments) -> Result<ExitCode> {
    let generated = prepare(arguments)?;
    let changed = files::write(&arguments.out, &generated.files).into_diagnostic()?;
    if !arguments.quiet {
        print!("{}", summary(&generated));
        println!("{}: {} files, {changed} changed", arguments.out.display(), generated.files.len());
    }
    Ok(ExitCode::SUCCESS)
}

fn check(arguments: &Arguments) -> Result<ExitCode> {
    let generated = prepare(arguments)?;
    let differences = files::compare(&arguments.out, &generated.files);
    if differences.is_empty() {
        if !arguments.quiet {
            println!("{}: {} files, all up to date", arguments.out.display(), generated.files.len());
        }
        return Ok(ExitCode::SUCCESS);
    }
    for (file, difference) in &differences {
        println!("{} {difference}", arguments.out.join(file).display());
    }
    println!("{} of {} files are stale: run codegen again", differences.len(), generated.files.len());
    Ok(ExitCode::from(1))
}

fn verify(arguments: &Arguments, checks: &CheckArguments) -> Result<ExitCode> {
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
    if checks.json {
        println!("{}", serde_json::to_string_pretty(&report).into_diagnostic()?);
    } else if !arguments.quiet || !report.holds() {
        print!("{}", report.text());
    }
    Ok(if report.holds() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn prepare(arguments: &Arguments) -> Result<Generated> {
    Ok(prepare_all(arguments)?.0)
}

fn prepare_all(arguments: &Arguments) -> Result<(Generated, Quantity, Options)> {
    let bar = progress(arguments);
    let (coefficients, sha256) = load(arguments)?;
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
    if !arguments.quiet && std::io::stderr().is_terminal() {
        bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar.set_message("reading");
    bar
}

fn load(arguments: &Arguments) -> Result<(Coefficients, String)> {
    let source = match (&arguments.coefficients, &arguments.recording, &arguments.mirror) {
        (Some(path), _, _) => Source::Coefficients(path.clone()),
        (None, Some(recording), Some(mirror)) => {
            Source::Recording { recording: recording.clone(), mirror: mirror.clone() }
        }
        _ => Source::Embedded,
    };
    source.load().map_err(|e| miette!("{e}"))
}

/// What was chosen and why, on one screen.
fn summary(generated: &Generated) -> String {
    let mut lines = String::new();
    for (routine, entry) in generated.routines.iter().zip(generated.certificate.routines.iter().step_by(2)) {
        let degree = routine.design.degree;
        let line = format!(
            "{:<24} degree {degree:>2}   proven within {} {}   best of this degree {:.2e}\n",
            entry.routine,
            text::rounded_up(entry.bound),
            entry.unit,
            entry.minimax,
        );
        lines.push_str(&line);
    }
    lines
}
