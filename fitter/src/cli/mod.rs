//! The command line of `fitter`: [`main`] is the program, [`run`] its body for a program that takes the same
//! [`Command`]s in.
//!
//! Results go to standard output, warnings and progress to standard error; colours only where someone looks and
//! `NO_COLOR` is not set. Exit code 2 for bad input, with one message.

mod apply;
mod fit;
mod init;
mod pages;
mod progress;
mod report;

use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use miette::Result;

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

/// How much is said, for every command.
#[derive(Args, Debug, Clone, Copy, Default)]
pub struct Common {
    /// Print the summary as JSON
    #[arg(long, global = true)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print everything that was found
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// The commands.
#[derive(Subcommand)]
pub enum Command {
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
    /// Print the completions of a shell
    Completions(pages::CompletionsArgs),
    /// Print the manual page, or write those of all commands
    Man(pages::ManArgs),
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
pub fn run(command: Command, common: Common) -> Result<()> {
    match command {
        Command::Fit(args) => fit::run(&args, common),
        Command::Apply(args) => apply::run(&args, common),
        Command::Report(args) => report::run(&args, common),
        Command::Init(args) => init::run(&args, common),
        Command::Schema => {
            say(crate::mirror::SCHEMA.trim_end());
            Ok(())
        }
        Command::Completions(args) => pages::completions(&args),
        Command::Man(args) => pages::man(&args, common),
    }
}

/// The program: parses the arguments, runs, and prints the message of what went wrong.
pub fn main() -> ExitCode {
    // Messages are one sentence each and stand on one line, whatever the width of the terminal.
    let plain = |_: &_| -> Box<dyn miette::ReportHandler> {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).break_words(false).build())
    };
    // Fails only if a hook is set already.
    let _ = miette::set_hook(Box::new(plain));
    let cli = Cli::parse();
    match run(cli.command, cli.common) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            eprintln!("{report:?}");
            ExitCode::from(2)
        }
    }
}

/// Prints a line or several. That nobody reads them to the end (`| head`) is no error.
fn say(text: &str) {
    use std::io::Write;
    let _ = writeln!(anstream::stdout(), "{text}");
}

/// Prints a warning, unless nothing is to be said.
fn warn(text: &str, common: Common) {
    use std::io::Write;
    if !common.quiet {
        let _ = writeln!(anstream::stderr(), "{0}warning:{0:#} {text}", crate::summary::WARNING);
    }
}

/// Prints a summary as JSON or for people.
fn summarise(common: Common, json: impl FnOnce() -> serde_json::Value, people: impl FnOnce() -> String) {
    match (common.json, common.quiet) {
        (true, _) => say(&format!("{:#}", json())),
        (false, false) => say(people().trim_end()),
        (false, true) => {}
    }
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
