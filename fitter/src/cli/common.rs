//! What the command lines of all programs share: how much is said, in which colours, and how a run ends.

use std::io::Write;
use std::process::ExitCode;

use clap::Args;
use miette::Result;

pub use crate::summary::{FIGURE, LABEL, WARNING, line};

/// How much is said and read, for every command of every program.
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
    /// Read at most so many bytes of a file, decompressed [default: 1073741824]
    #[arg(long, global = true, value_name = "N")]
    pub max_bytes: Option<u64>,
    /// Read at most so many columns of a recording [default: 512]
    #[arg(long, global = true, value_name = "N")]
    pub max_columns: Option<u64>,
}

impl Common {
    /// Lets the limits of what is read hold in this process.
    pub fn limit(&self) {
        crate::input::limit(self.max_bytes, self.max_columns);
    }

    /// Whether someone watches standard error and wants to see how far the work is.
    pub fn watched(&self) -> bool {
        use std::io::IsTerminal;
        !self.quiet && std::io::stderr().is_terminal()
    }
}

/// Prints a line or several. That nobody reads them to the end (`| head`) is no error.
pub fn say(text: &str) {
    let _ = writeln!(anstream::stdout(), "{text}");
}

/// Prints a warning, unless nothing is to be said.
pub fn warn(text: &str, common: Common) {
    if !common.quiet {
        let _ = writeln!(anstream::stderr(), "{WARNING}warning:{WARNING:#} {text}");
    }
}

/// Prints a summary as JSON or for people.
pub fn summarise(common: Common, json: impl FnOnce() -> serde_json::Value, people: impl FnOnce() -> String) {
    match (common.json, common.quiet) {
        (true, _) => say(&format!("{:#}", json())),
        (false, false) => say(people().trim_end()),
        (false, true) => {}
    }
}

/// Runs a program's body and prints the message of what went wrong; 2 is the exit code of bad input.
pub fn program(run: impl FnOnce() -> Result<ExitCode>) -> ExitCode {
    // Messages are one sentence each and stand on one line, whatever the width of the terminal.
    let plain = |_: &_| -> Box<dyn miette::ReportHandler> {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).break_words(false).build())
    };
    // Fails only if a hook is set already.
    let _ = miette::set_hook(Box::new(plain));
    run().unwrap_or_else(|report| {
        eprintln!("{report:?}");
        ExitCode::from(2)
    })
}
