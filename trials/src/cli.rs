//! The command line of `trials`: [`main`] is the program, [`run`] its body for a program that takes the same
//! [`Command`]s in. Exit code 0 where every figure is reached, 1 where one is not, 2 for bad input.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use fitter::cli::Common;
use fitter::cli::common::program;
use miette::{IntoDiagnostic, Result, miette};
use serde::Serialize;

use crate::campaign::{Campaign, put};
use crate::plan::{Counts, cells};
use crate::report::Report;
use crate::summary::Summary;
use crate::{dynamic, examples, real, workspace};

/// Conceals physical effects in simulated recordings, has `diagnose` run on the recordings alone, and scores it.
#[derive(Parser)]
#[command(name = "trials", version, after_help = EXAMPLES)]
pub struct Cli {
    /// How much is said.
    #[command(flatten)]
    pub common: Common,
    /// What is tried.
    #[command(subcommand)]
    pub command: Command,
}

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  trials static                                              3000 trials and 8000 nulls: an hour or two
  trials static --trials 300 --nulls 50 --skip-without       some minutes
  trials static --trials 0 --nulls 0 --coverage 400 --only local_defect --only sensor_clipping
  trials static --trials 0 --nulls 0 --twice 1000            some minutes
  trials dynamic --trials 50 --seed 2 --json";

/// The commands.
#[derive(Subcommand)]
pub enum Command {
    /// Static calibrations
    Static(Static),
    /// Moving mechanisms
    Dynamic(Dynamic),
}

/// The program: parses the arguments, runs, and prints the message of what went wrong.
pub fn main() -> ExitCode {
    program(Cli::try_parse(), |cli| run(&cli.command, cli.common))
}

/// Arguments of `trials dynamic`.
#[derive(Args)]
pub struct Dynamic {
    /// Trials: a fifth of them nulls, the others with something concealed
    #[arg(long, default_value_t = 500)]
    trials: usize,
    /// Seed of everything: the same seed gives the same report
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all processors if not given
    #[arg(long)]
    jobs: Option<std::num::NonZeroUsize>,
    /// Recordings under feedback besides, half of them nulls
    #[arg(long, default_value_t = 0)]
    feedback: usize,
    /// The folder for recordings, answers and the report (report.json, report.html; examples.json where
    /// ARCSMITH_EXAMPLES names the folder of opened recordings)
    #[arg(long, default_value = "target/trials-dynamic")]
    out: PathBuf,
}

/// Arguments of `trials static`.
#[derive(Args)]
pub struct Static {
    /// Trials with something concealed
    #[arg(long, default_value_t = 3000)]
    trials: usize,
    /// Nulls of each of the four noise families
    #[arg(long, default_value_t = 2000)]
    nulls: usize,
    /// Devices with one effect that is found for certain (ρ ≥ 8.2), for every effect in every schedule: how often its
    /// intervals hold the truth
    #[arg(long, default_value_t = 0)]
    coverage: usize,
    /// With --coverage: this effect alone; may be repeated
    #[arg(long, requires = "coverage")]
    only: Vec<String>,
    /// Devices with one to three effects of any strength that are recorded twice: how often the model of the first
    /// recording makes the second worse than the base alone
    #[arg(long, default_value_t = 0)]
    twice: usize,
    /// Seed of everything: the same seed gives the same report
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all processors if not given
    #[arg(long)]
    jobs: Option<std::num::NonZeroUsize>,
    /// The folder for recordings, answers and the report (report.json, report.html; examples.json and real.json
    /// where ARCSMITH_EXAMPLES and ARCSMITH_RECORDINGS name the folders of opened and of real recordings)
    #[arg(long, default_value = "target/trials")]
    out: PathBuf,
    /// Do not leave each effect out of the catalogue in turn
    #[arg(long)]
    skip_without: bool,
}

/// Runs a command; the exit code says whether every figure was reached.
///
/// # Errors
/// One message.
pub fn run(command: &Command, common: Common) -> Result<ExitCode> {
    common.limit();
    if common.quiet {
        workspace::hush();
    }
    let mut summary = Summary::new(common);
    let reached = match command {
        Command::Static(args) => run_static(args, &mut summary)?,
        Command::Dynamic(args) => run_dynamic(args, &mut summary)?,
    };
    summary.end(reached);
    Ok(if reached { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn threads(jobs: Option<std::num::NonZeroUsize>) -> Result<usize> {
    match jobs {
        Some(jobs) => Ok(jobs.get()),
        None => Ok(std::thread::available_parallelism().into_diagnostic()?.get()),
    }
}

fn run_dynamic(args: &Dynamic, summary: &mut Summary) -> Result<bool> {
    let jobs = threads(args.jobs)?;
    let campaign =
        dynamic::campaign::Campaign { trials: args.trials, seed: args.seed, jobs, out: args.out.clone() };
    let outcome = campaign.run(|hash, count| summary.sealed(hash, count)).into_diagnostic()?;
    let report = Report::of_dynamic(&campaign, &outcome);
    report.write(&args.out).into_diagnostic()?;
    let mut reached = summary.campaign(&report.score.figures, report.score.misses.len(), &args.out);
    if args.feedback > 0 {
        let folder = args.out.join("feedback");
        let figures = dynamic::feedback::run(args.feedback, args.seed, jobs, &folder).into_diagnostic()?;
        reached &= summary.set("Under feedback", &figures, &[]);
    }
    let opened = std::env::var_os("ARCSMITH_EXAMPLES").map(PathBuf::from);
    let scored = match &opened {
        Some(folder) => {
            dynamic::examples::score(folder, &args.out.join("examples"), jobs).into_diagnostic()?
        }
        None => None,
    };
    match scored {
        Some(scored) => reached &= summary.set(OPENED, &scored.figures, &scored.misses),
        None => {
            summary.skipped("Opened examples are skipped: ARCSMITH_EXAMPLES names no folder that holds them")
        }
    }
    Ok(reached)
}

const OPENED: &str = "Opened examples of an independent laboratory";

fn run_static(args: &Static, summary: &mut Summary) -> Result<bool> {
    let jobs = threads(args.jobs)?;
    if let Some(unknown) = args.only.iter().find(|id| !cells().iter().any(|cell| cell.0 == **id)) {
        return Err(miette!("--only {unknown}: found no such effect; `diagnose --effects` lists them"));
    }
    let counts = Counts {
        trials: args.trials,
        nulls: args.nulls,
        intervals: args.coverage,
        only: args.only.clone(),
        twice: args.twice,
    };
    let campaign =
        Campaign { counts, seed: args.seed, jobs, without: !args.skip_without, out: args.out.clone() };
    let outcome = campaign.run(|hash, count| summary.sealed(hash, count)).into_diagnostic()?;
    let report = Report::of_static(&campaign, &outcome);
    report.write(&args.out).into_diagnostic()?;
    let mut reached = summary.campaign(&report.score.figures, report.score.misses.len(), &args.out);
    match std::env::var_os("ARCSMITH_EXAMPLES") {
        Some(folder) => {
            let scored = examples::score(&PathBuf::from(folder), &args.out.join("examples"), jobs)
                .into_diagnostic()?;
            write(&args.out, "examples.json", &scored)?;
            reached &= summary.set(OPENED, &scored.figures, &scored.misses);
        }
        None => summary.skipped("Opened examples are skipped: ARCSMITH_EXAMPLES names no folder"),
    }
    match std::env::var_os("ARCSMITH_RECORDINGS") {
        Some(folder) => {
            let figures =
                real::figures(&PathBuf::from(folder), &args.out.join("real"), jobs).into_diagnostic()?;
            write(&args.out, "real.json", &figures)?;
            reached &= summary.set("Real recordings", &figures, &[]);
        }
        None => summary.skipped("Real recordings are skipped: ARCSMITH_RECORDINGS names no folder"),
    }
    Ok(reached)
}

fn write(folder: &Path, name: &str, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).into_diagnostic()? + "\n";
    put(&folder.join(name), &text).into_diagnostic()
}
