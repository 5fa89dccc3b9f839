//! `generate`.

use std::process::ExitCode;

use serde_json::json;

use super::terminal::{FIGURE, line, summarise, warn};
use super::{Arguments, Result, check, devices, encoder, source};
use crate::budget::in_words;
use crate::certificate::Certificate;
use crate::generate::Generated;
use crate::language::ALL;
use crate::{files, text};

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith generate --demo --out firmware/demo
  arcsmith generate --coefficients coefficients.json --out firmware/angle --format q31 --input x1x2-counts \\
      --bits 16 --gain 1.2207e-5 --output nano
  arcsmith generate --for moteus --coefficients encoder.json --out firmware/moteus
  arcsmith generate --recording slit.csv.gz --mirror slit.toml --bound 0.0001mm --out slit
  arcsmith check --coefficients coefficients.json --out firmware/angle";

impl Arguments {
    /// Generates and writes, or compares where `--check` is given; the exit code is 1 where something is stale.
    ///
    /// # Errors
    /// Anything that is wrong with the input, in a sentence; nothing is written then.
    pub fn generate(&self) -> Result<ExitCode> {
        self.common.limit();
        match self {
            checked if checked.check => check::check(checked),
            of_many if !of_many.devices.is_empty() => devices::write(of_many),
            _ => write(self),
        }
    }
}

fn write(arguments: &Arguments) -> Result<ExitCode> {
    source::tell(arguments)?;
    let generated = arguments.prepare()?.0;
    let changed = files::write(&arguments.out, &generated.files)?;
    let (out, count) = (arguments.out.display().to_string(), generated.files.len());
    for missing in &generated.unreachable {
        warn(&format!("left out: {missing}"), arguments.common);
    }
    if let Some(open) = &generated.certificate.reservation {
        warn(open, arguments.common);
    }
    summarise(
        arguments.common,
        || {
            json!({
                "reservation": generated.certificate.reservation,
                "routines": generated.certificate.routines,
                "out": out,
                "files": generated.files.keys().collect::<Vec<_>>(),
                "changed": changed,
            })
        },
        || {
            summary(&generated, arguments.common.verbose)
                + &encoder::summary(&generated, arguments.firmware.is_some())
                + &uncertain(&generated.certificate)
                + &line("written", &format!("{out}: {count} files, {changed} changed"))
        },
    );
    Ok(ExitCode::SUCCESS)
}

/// How far a corrected reading may be from the truth, and what no routine of these has.
fn uncertain(certificate: &Certificate) -> String {
    let budget = certificate.budgets.first().map(|of| {
        let (expanded, _) = in_words(&of.budget);
        let lacks = if of.budget.missing.is_empty() { "" } else { ", and something is missing in it" };
        line(
            "uncertainty",
            &format!("U = {expanded} for 95 % of single readings (not proved{lacks}): see budget"),
        )
    });
    let left_out = certificate.routines.iter().take(1).flat_map(|entry| &entry.left_out);
    budget.into_iter().chain(left_out.map(|out| line("left out", out))).collect()
}

/// What was chosen and why, on one screen; `verbose` adds what every bound is made of.
fn summary(generated: &Generated, verbose: bool) -> String {
    let mut lines = String::new();
    for (routine, entry) in
        generated.routines.iter().zip(generated.certificate.routines.iter().step_by(ALL.len()))
    {
        let degree = routine.design.degree;
        let bound = format!("{} {}", text::rounded_up(entry.bound), entry.unit);
        lines += &format!(
            "{:<24} degree {degree:>2}   proven within {FIGURE}{bound}{FIGURE:#}   best of this degree {:.2e}\n",
            entry.routine, entry.minimax,
        );
        for part in entry.parts.iter().filter(|_| verbose) {
            lines += &line("", &format!("{:>10}  {}", text::rounded_up(part.value), part.what));
        }
    }
    lines
}
