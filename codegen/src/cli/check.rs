//! `check`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use serde_json::json;

use super::terminal::{FIGURE, WARNING, say, say_json};
use super::{Arguments, Result, Verify, devices, source};
use crate::files;

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith check --demo
  arcsmith check --coefficients coefficients.json --out firmware/angle --sweep";

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct Check {
    /// How the files were generated.
    #[command(flatten)]
    arguments: Arguments,
    /// Also verify the certificate, and sweep the compiled Rust and C: what `verify` does without further options.
    #[arg(long)]
    sweep: bool,
}

impl Check {
    /// Compares; the exit code is 1 where something is stale or does not hold.
    ///
    /// # Errors
    /// As [`Arguments::generate`].
    pub fn run(self) -> Result<ExitCode> {
        self.arguments.common.limit();
        if self.sweep { Verify::of(self.arguments).run() } else { check(&self.arguments) }
    }
}

pub(super) fn check(arguments: &Arguments) -> Result<ExitCode> {
    if !arguments.devices.is_empty() {
        return stale(arguments, &devices::prepare(arguments)?.files);
    }
    source::tell(arguments)?;
    stale(arguments, &arguments.prepare()?.0.files)
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
