//! `verify`.

use std::process::ExitCode;

use clap::Args;
use serde::Serialize;

use super::terminal::{Watched, say, say_json};
use super::{Arguments, Result, devices, encoder, source};
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
    pub(super) checks: CheckArguments,
}

/// What is checked beside the certificate and a sweep.
#[derive(Debug, Default, Args)]
pub(super) struct CheckArguments {
    /// Sweep every representable input, not only a part of them.
    #[arg(long)]
    pub exhaustive: bool,
    /// Sweep the C once more with undefined behaviour watched for.
    #[arg(long)]
    pub sanitize: bool,
    /// Let Gappa prove the rounding of the operations from the scripts beside the code.
    #[arg(long)]
    pub gappa: bool,
    /// Let Frama-C look for undefined behaviour in the C over every input word.
    #[arg(long)]
    pub frama_c: bool,
    /// Check the C with cppcheck's MISRA rules and all warnings of gcc and clang.
    #[arg(long)]
    pub misra: bool,
    /// Look for panics in the Rust object, overflow checks on; and let rustdoc check the documentation.
    #[arg(long)]
    pub objects: bool,
    /// Damage copies of the files on purpose, and see that every damage is caught.
    #[arg(long)]
    pub mutants: bool,
}

impl CheckArguments {
    /// The first option of a check that this kind of routine has not; `has` are those that it has.
    pub fn beyond(&self, has: &[&str]) -> Option<&'static str> {
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
        Verify { arguments, checks: CheckArguments::default() }
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
        source::tell(arguments)?;
        let (coefficients, sha256) = arguments.load()?;
        if coefficients.whole_turn() {
            return encoder::verify(arguments, checks, &coefficients, &sha256);
        }
        let (generated, quantity, options) = arguments.prepare()?;
        let wanted = Checks {
            exhaustive: checks.exhaustive,
            sanitize: checks.sanitize,
            gappa: checks.gappa,
            frama_c: checks.frama_c,
            misra: checks.misra,
            objects: checks.objects,
            mutants: checks.mutants,
        };
        let bar = Watched(arguments.progress());
        let report = verify(&arguments.out, &generated, &quantity, &options, wanted, &bar)?;
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
