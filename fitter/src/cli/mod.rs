//! The command line of `fitter`: [`main`] is the program, [`run`] its body for a program that takes the same
//! [`Command`]s in.
//!
//! Results go to standard output, warnings and progress to standard error; colours only where someone looks and
//! `NO_COLOR` is not set. Exit code 2 for bad input, with one message.

mod apply;
pub mod common;
mod fit;
mod init;
pub mod pages;
mod progress;
mod report;

use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};
use miette::Result;

pub use common::Common;
use common::{program, say, summarise, warn};

use crate::recording::Mapping;

/// Fits the error model of an angle or position sensor to calibration recordings, and applies it.
#[derive(Parser)]
#[command(name = "fitter", version, after_help = EXAMPLES)]
pub struct Cli {
    /// How much is said.
    #[command(flatten)]
    pub common: Common,
    /// What is done.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  fitter init --kind mirror                                       write a commented mirror.toml
  fitter fit calibration.csv --mirror mirror.toml                 choose the order, write coefficients.json
  fitter apply scan.csv --coefficients coefficients.json          correct every row, write angles.csv
  fitter report calibration.csv --mirror mirror.toml              figures as a page and as SVG
  fitter fit lab.parquet --mirror mirror.toml --map x1_mm=Probe1:um --map x2_mm=Probe2:um";

/// The commands.
#[derive(Subcommand)]
pub enum Command {
    /// The work.
    #[command(flatten)]
    Work(Work),
    /// Print the completions of a shell
    #[command(after_help = COMPLETIONS)]
    Completions(pages::CompletionsArgs),
    /// Print the manual page, or write those of all commands
    #[command(after_help = MANUAL)]
    Man(pages::ManArgs),
}

/// Examples for the help of `completions`.
pub const COMPLETIONS: &str = "\
Examples:
  fitter completions bash > ~/.local/share/bash-completion/completions/fitter
  fitter completions zsh > \"${fpath[1]}/_fitter\"";

/// Examples for the help of `man`.
pub const MANUAL: &str = "\
Examples:
  fitter man | man -l -
  fitter man --out ~/.local/share/man/man1";

/// The commands that do something, for this program and for one that takes them in.
#[derive(Subcommand)]
pub enum Work {
    /// Choose the order, identify the coefficients, write coefficients.json
    Fit(fit::FitArgs),
    /// Write the corrected reading of every row of a recording
    Apply(apply::ApplyArgs),
    /// Draw a calibration and its verification as one page and as SVG files
    Report(report::ReportArgs),
    /// Write a commented mirror.toml to fill in
    Init(init::InitArgs),
    /// Print the JSON schema of mirror.toml
    Schema,
}

/// Columns under other names.
#[derive(Args, Debug, Clone, Default)]
pub struct MapArgs {
    /// A column under another name, in another unit: `x1_mm=Probe1:um`, `measured=enc:14bit`
    #[arg(long = "map", value_name = "NAME=COLUMN[:UNIT]")]
    pub map: Vec<Mapping>,
}

/// Runs a command.
///
/// # Errors
/// One message; nothing was written.
pub fn run(command: Work, common: Common) -> Result<()> {
    common.limit();
    match command {
        Work::Fit(args) => fit::run(&args, common),
        Work::Apply(args) => apply::run(&args, common),
        Work::Report(args) => report::run(&args, common),
        Work::Init(args) => init::run(&args, common),
        Work::Schema => {
            say(crate::mirror::SCHEMA.trim_end());
            Ok(())
        }
    }
}

/// The program: parses the arguments, runs, and prints the message of what went wrong.
pub fn main() -> ExitCode {
    program(Cli::try_parse(), |cli| {
        match cli.command {
            Command::Work(command) => run(command, cli.common)?,
            Command::Completions(args) => pages::completions(&args, Cli::command()),
            Command::Man(args) => pages::man(&args, Cli::command(), cli.common)?,
        }
        Ok(ExitCode::SUCCESS)
    })
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
    let typed = std::env::args_os().skip(1).map(|argument| quoted(argument.to_string_lossy().into_owned()));
    let words: Vec<String> = std::iter::once("fitter".to_string()).chain(typed).collect();
    crate::text_safety::command(&words.join(" "))
}
