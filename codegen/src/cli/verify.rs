//! `verify`.

use std::process::ExitCode;

use clap::Args;
use serde::Serialize;

use super::terminal::{Watched, say, say_json};
use super::{Arguments, Result, devices, encoder, source, tables};
use crate::verify::{Checks, verify};

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith verify --demo
  arcsmith verify --coefficients coefficients.json --out firmware/angle --exhaustive
  arcsmith verify --demo --gappa --frama-c --misra --sanitize --objects";

/// Arguments of `verify`.
#[derive(Debug, Args)]
pub struct Verify {
    /// How the files were generated.
    #[command(flatten)]
    pub(super) arguments: Arguments,
    #[command(flatten)]
    pub(super) checks: Checks,
}

impl Checks {
    /// The first option of a check that this kind of routine has not; `has` are those that it has.
    pub(super) fn beyond(&self, has: &[&str]) -> Option<&'static str> {
        let given = [
            ("--exhaustive", self.exhaustive),
            ("--gappa", self.gappa),
            ("--frama-c", self.frama_c),
            ("--misra", self.misra),
            ("--objects", self.objects),
            ("--sanitize", self.sanitize),
            ("--mutants", self.mutants),
        ];
        given.into_iter().find(|(option, given)| *given && !has.contains(option)).map(|(option, _)| option)
    }
}

impl Verify {
    /// With the checks that need nothing but compilers.
    pub(super) fn of(arguments: Arguments) -> Verify {
        Verify { arguments, checks: Checks::default() }
    }

    /// Verifies; the exit code is 1 where something does not hold.
    ///
    /// # Errors
    /// As [`Arguments::generate`].
    pub fn run(self) -> Result<ExitCode> {
        let Verify { arguments, checks } = &self;
        arguments.common.limit();
        if !arguments.devices.is_empty() {
            return devices::verify(arguments, checks);
        }
        tables::not_compiled(arguments)?;
        source::tell(arguments)?;
        let (coefficients, sha256) = arguments.load()?;
        if coefficients.whole_turn() {
            return encoder::verify(arguments, checks, &coefficients, &sha256);
        }
        let (generated, options) = arguments.prepare()?;
        let bar = Watched(arguments.progress());
        let report = verify(&arguments.out, &generated, &options, *checks, &bar)?;
        bar.0.finish_and_clear();
        conclude(arguments, &report, report.holds(), &report.text())
    }
}

/// Says what a verification found, and ends with 1 where something does not hold.
pub(super) fn conclude(
    arguments: &Arguments,
    report: &impl Serialize,
    holds: bool,
    text: &str,
) -> Result<ExitCode> {
    if arguments.common.json {
        say_json(&serde_json::to_string_pretty(report)?);
    } else if !arguments.common.quiet || !holds {
        say(text.trim_end());
    }
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::from(1) })
}
