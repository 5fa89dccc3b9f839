//! Coefficients of a whole turn: the routine of an encoder.

use std::process::ExitCode;

use fitter::coefficients::Coefficients;

use super::terminal::warn;
use super::verify::conclude;
use super::{Arguments, Result, options};
use crate::generate::{Generated, generate};
use crate::options::Options;
use crate::quantity::Quantity;
use crate::text;
use crate::turn::{assumed_bits, verify};
use crate::verify::Checks;

/// Generates the files.
pub(super) fn prepare(
    arguments: &Arguments,
    coefficients: &Coefficients,
    sha256: &str,
) -> Result<(Generated, Options)> {
    let unit = Quantity::of(&coefficients.error_model()).bound_unit;
    let options = options::encoder_options(arguments, &unit)?;
    if options.encoder.assumes(coefficients)
        && let Some(bits) = assumed_bits(coefficients)
    {
        let what = format!(
            "the encoder's word is taken to have {bits} bits, whose rounding is within a tenth of the noise: give --bits or \
             --counts if it has others"
        );
        warn(&what, arguments.common);
    }
    Ok((generate(coefficients, sha256, &options)?, options))
}

/// Sweeps every word through the compiled files.
pub(super) fn verify(
    arguments: &Arguments,
    checks: &Checks,
    coefficients: &Coefficients,
    sha256: &str,
) -> Result<ExitCode> {
    // `--exhaustive` is what happens anyway.
    if let Some(option) = checks.beyond(&["--exhaustive"]) {
        return Err(options::not_of_encoders(option));
    }
    let (generated, options) = prepare(arguments, coefficients, sha256)?;
    let report = verify::verify(&arguments.out, &generated, coefficients, &options)?;
    conclude(arguments, &report, report.holds(), &report.text())
}

/// What was chosen, in a line; nothing for other sensors. `table` where it is one of firmware that exists.
pub(super) fn summary(generated: &Generated, table: bool) -> String {
    let entry = generated.certificate.routines.first().filter(|_| generated.routines.is_empty());
    entry.map_or_else(String::new, |entry| {
        let form = match entry.degree {
            _ if table => format!("{} entries, {}", entry.segments, entry.format),
            0 => format!("table of every count, {}", entry.format),
            degree => format!("{} of degree {degree}, {}", entry.segments, entry.format),
        };
        let bound = text::rounded_up(entry.bound);
        let counts = match table {
            true => String::new(),
            false => format!(" ({:.3} counts)", entry.bound / entry.output.lsb),
        };
        format!("{:<24} {form}   proven within {bound} {}{counts}\n", entry.routine, entry.unit)
    })
}
