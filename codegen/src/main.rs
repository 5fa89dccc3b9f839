//! `cargo run -p codegen` regenerates `generated/` from the embedded recording; `-- check` compares. It takes the
//! arguments of `arcsmith generate` and `arcsmith check`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use codegen::cli::{Arguments, Check, terminal};

/// Generates the firmware correction of a scanning mirror, in Rust and C, with a proven error bound.
///
/// In the project's own folder it generates from the embedded recording; elsewhere from the coefficients that are named,
/// or from the one file of them that lies in the folder.
#[derive(Debug, Parser)]
#[command(name = "codegen", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    arguments: Arguments,
}

const EXAMPLES: &str = "\
Examples:
  cargo run -p codegen                                         regenerate the committed files
  cargo run -p codegen -- check                                compare them
  cargo run -p codegen -- --demo --format q31 --out firmware   the arguments of `arcsmith generate`";

#[derive(Debug, Subcommand)]
enum Command {
    /// Compare what is in the output folder with what would be generated
    ///
    /// The exit code is 1 where the folder is stale; nothing is written.
    Check(Check),
}

fn main() -> ExitCode {
    terminal::program(Cli::try_parse(), |cli| match cli.command {
        Some(Command::Check(check)) => check.run(),
        None => cli.arguments.generate(),
    })
}
