//! `arcsmith`: arguments, progress and printing. Every command has a file of its name; `generate`, `check` and `verify`
//! are those of `codegen::cli`, which the package `codegen` needs for its own program.
//!
//! [`run`] is the whole program. Where another program holds it, a Python module for example, it gives the words itself.

mod apply;
mod budget;
mod compare;
mod completions;
mod diagnose;
mod effects;
mod encode;
mod excite;
mod explore;
mod fit;
mod fleet;
mod init;
mod man;
mod next;
mod project;
mod record;
mod report;
mod simulate;
mod trials;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use codegen::cli::{self, terminal};

use terminal::{Common, Result, program, say};

/// What the program says and asks beside the libraries, for another program that holds it.
pub mod shared {
    pub use crate::diagnose::{declared, motion, summary as diagnosis_summary};
    pub use crate::fit::{command_line, summary as fit_summary};
    pub use crate::fleet::{answer as fleet_answer, choice as fleet_choice, table as fleet_table};
}

/// Calibration recordings of a mirror or an encoder in, proven firmware correction out.
#[derive(Parser)]
#[command(name = "arcsmith", version, after_help = EXAMPLES)]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  arcsmith init --from calibration.csv                                   a project: arcsmith.toml
  arcsmith run                                                           fit, diagnose and generate what is stale
  arcsmith                                                               what is done, and what to do next
Without a project:
  arcsmith init --out mirror.toml                                        the design values of a mirror
  arcsmith fit calibration.csv --mirror mirror.toml                      choose the order, write coefficients.json
  arcsmith generate --coefficients coefficients.json --out firmware      Rust, C, and the certificate of their bound
  arcsmith diagnose calibration.csv --mirror mirror.toml --out diagnosis what the model leaves out
  arcsmith record --protocol calibration --seed 7 --out calibration.csv  a simulated recording to try it with";

#[derive(Subcommand)]
enum Command {
    /// Choose the order, identify the coefficients, write coefficients.json
    Fit(fit::FitArgs),
    /// Write the corrected reading of every row of a recording
    Apply(apply::ApplyArgs),
    /// Draw a calibration and its verification as one page and as SVG files
    Report(report::ReportArgs),
    /// Write a commented project file, arcsmith.toml, or the nominal mirror alone
    Init(init::InitArgs),
    /// Fit, diagnose and generate what is stale in a project
    Run(project::run::RunArgs),
    /// Say what is done in a project, what is stale and why, and what to do next
    ///
    /// The same as `arcsmith` alone in the folder of a project.
    Status(project::status::StatusArgs),
    /// Print the JSON schema of mirror.toml
    Schema,
    /// Locate where recordings differ from their simulation, name the physics, show that the fit improves
    #[command(after_help = diagnose::EXAMPLES)]
    Diagnose(diagnose::Arguments),
    /// Say what changed between two recordings: of a device at two times, of a healthy and a suspect one
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::CompareArgs),
    /// Diagnose many units of one kind, and pool what they show together
    #[command(after_help = fleet::EXAMPLES)]
    Fleet(Box<fleet::FleetArgs>),
    /// Generate the correction in Rust and C, with a proven bound
    ///
    /// Generates from the coefficients that are named, or from the one file of them that lies in the folder.
    #[command(after_help = cli::GENERATE)]
    Generate(Box<cli::Arguments>),
    /// Compare what is in the output folder with what would be generated
    ///
    /// The exit code is 1 where the folder is stale; nothing is written. Without options in a project it is
    /// `status --strict`.
    #[command(after_help = cli::CHECK)]
    Check(Box<cli::Check>),
    /// State the uncertainty of a corrected reading after the GUM: every contribution, combined and expanded, over the range
    Budget(Box<budget::BudgetArgs>),
    /// List the Pareto-optimal routines (bound, instructions, flash) for every core
    Explore(Box<explore::ExploreArgs>),
    /// Check the generated files from outside
    ///
    /// Recomputes the certificate and sweeps the compiled Rust and C against a bounded reference; the exit code
    /// is 1 where anything does not hold.
    #[command(after_help = cli::VERIFY)]
    Verify(Box<cli::Verify>),
    /// Simulate a calibration: step a mirror in closed loop on the calculated angle, and write its log
    Record(record::Record),
    /// Simulate a magnetic encoder that is turned against a reference, and write what both read
    Encode(encode::Encode),
    /// Simulate a mirror that is excited, and write drive and position
    Excite(excite::Excite),
    /// Run a plant, with all that was found in it, on the drive of a recording, and write the position
    Simulate(simulate::Simulate),
    /// Print the effects that can be named, list those that can be simulated, check your own
    #[command(after_help = effects::EXAMPLES)]
    Effects(effects::EffectsArgs),
    /// Conceal effects in simulated recordings, have them diagnosed blind, and score the answers
    Trials(trials::TrialsArgs),
    /// Print the completions of a shell
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write those of all commands
    Man(man::ManArgs),
}

/// Runs the program: `words` are its own name or path, the command and the options.
pub fn run(words: Vec<OsString>) -> ExitCode {
    parquet_tables::register();
    terminal::called_with(words, || match project::complete::asked(terminal::called().into_iter()) {
        Ok(None) => program(Cli::try_parse_from(terminal::called()), command),
        Ok(Some(asked)) => program(asked.parsed(), project::complete::Asked::run),
        Err(refused) => program(Ok(refused), Err),
    })
}

fn command(Cli { common, command }: Cli) -> Result<ExitCode> {
    common.limit();
    match command {
        Command::Fit(args) => fit::run(&args, common)?,
        Command::Apply(args) => apply::run(&args, common)?,
        Command::Report(args) => report::run(&args, common)?,
        Command::Init(args) => init::run(&args, common)?,
        Command::Run(args) => project::run::run(&args, common)?,
        Command::Status(args) => return project::status::run(&args, common),
        Command::Schema => say(fitter::mirror::SCHEMA.trim_end()),
        Command::Diagnose(args) => diagnose::run(&args, common)?,
        Command::Compare(args) => compare::run(&args, common)?,
        Command::Fleet(args) => fleet::run(&args, common)?,
        Command::Generate(arguments) => return arguments.generate(),
        Command::Check(check) => return check.run(),
        Command::Budget(args) => budget::run(&args)?,
        Command::Explore(args) => return explore::run(&args),
        Command::Verify(verify) => return verify.run(),
        Command::Record(args) => record::run(args, common)?,
        Command::Encode(args) => encode::run(&args, common)?,
        Command::Excite(args) => excite::run(args, common)?,
        Command::Simulate(args) => simulate::run(&args, common)?,
        Command::Effects(args) => effects::run(&args, common)?,
        Command::Trials(args) => return trials::run(&args, common),
        Command::Completions(args) => completions::run(&args, Cli::command()),
        Command::Man(args) => man::run(&args, Cli::command(), common)?,
    }
    Ok(ExitCode::SUCCESS)
}
