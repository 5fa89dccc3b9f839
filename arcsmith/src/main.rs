//! `arcsmith`: one front door over `fitter`, `codegen`, `diagnose`, `twin` and `trials`. Every command is that of
//! the single program, from the same function.

mod rename;

use std::process::ExitCode;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use fitter::cli::common::program;
use fitter::cli::{Common, pages};
use miette::Result;

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
  arcsmith init                                                          write a commented mirror.toml
  arcsmith fit calibration.csv --mirror mirror.toml                      choose the order, write coefficients.json
  arcsmith generate --coefficients coefficients.json --out firmware      Rust, C, and the certificate of their bound
  arcsmith diagnose calibration.csv --mirror mirror.toml --out diagnosis what the model leaves out
  arcsmith record --protocol calibration --seed 7 --out calibration.csv  a simulated recording to try it with";

#[derive(Subcommand)]
enum Command {
    #[command(flatten)]
    Fit(fitter::cli::Work),
    /// Locate where recordings differ from their simulation, name the physics, show that the fit improves
    #[command(after_help = diagnosis::cli::EXAMPLES)]
    Diagnose(diagnosis::cli::Arguments),
    /// Generate the correction in Rust and C, with a proven bound
    ///
    /// Generates from the coefficients that are named, or from the one file of them that lies in the folder.
    #[command(after_help = codegen::cli::EXAMPLES)]
    Generate(Box<codegen::cli::Arguments>),
    #[command(flatten)]
    Check(Box<codegen::cli::Command>),
    #[command(flatten)]
    Simulate(twin::cli::Command),
    /// Conceal effects in simulated recordings, have them diagnosed blind, and score the answers
    #[command(after_help = trials::cli::EXAMPLES)]
    Trials(Trials),
    /// Print the completions of a shell
    #[command(after_help = fitter::cli::COMPLETIONS)]
    Completions(pages::CompletionsArgs),
    /// Print the manual page, or write those of all commands
    #[command(after_help = fitter::cli::MANUAL)]
    Man(pages::ManArgs),
}

#[derive(Args)]
struct Trials {
    #[command(subcommand)]
    command: trials::cli::Command,
}

fn main() -> ExitCode {
    let own = rename::renamed(Cli::command());
    let parsed = own.clone().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    program(parsed, |cli| run(cli, own))
}

fn run(cli: Cli, own: clap::Command) -> Result<ExitCode> {
    let common = cli.common;
    match cli.command {
        Command::Fit(command) => fitter::cli::run(command, common)?,
        Command::Diagnose(arguments) => diagnosis::cli::run(&arguments, common)?,
        Command::Generate(arguments) => return codegen::cli::generated(&arguments),
        Command::Check(command) => return codegen::cli::run(&command),
        Command::Simulate(command) => twin::cli::run(command, common)?,
        Command::Trials(trials) => return trials::cli::run(&trials.command, common),
        Command::Completions(args) => pages::completions(&args, own),
        Command::Man(args) => pages::man(&args, own, common)?,
    }
    Ok(ExitCode::SUCCESS)
}
