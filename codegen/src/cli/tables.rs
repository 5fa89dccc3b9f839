//! `--for`: the table of firmware that exists.

use fitter::coefficients::Coefficients;

use super::{Arguments, Result, options};
use crate::generate::Generated;
use crate::options::Options;
use crate::quantity::Quantity;
use crate::refused;
use crate::tables::{self, Asked, Firmware, Wanted};

/// Makes the table.
pub(super) fn prepare(
    arguments: &Arguments,
    firmware: Firmware,
    coefficients: &Coefficients,
    sha256: &str,
) -> Result<(Generated, Options)> {
    let a = arguments;
    let of_routines = [
        ("--target", a.target.is_some()),
        ("--flash-bytes", a.flash_bytes.is_some()),
        ("--output-bits", a.output_bits.is_some()),
        ("--name", a.name.is_some()),
    ];
    let of_routines = of_routines.into_iter().find(|(_, given)| *given).map(|(option, _)| option);
    if let Some(option) = options::of_other_sensors(a).or(of_routines) {
        return Err(refused!("{option} belongs to a routine, and --for makes a table").mend("leave it out"));
    }
    let unit = Quantity::of(&coefficients.error_model()).bound_unit;
    let options = options::options(a, &unit, false)?;
    let asked =
        Asked { wanted: Wanted { source: a.source, entries: a.entries, ratio: a.ratio }, options: &options };
    let generated = tables::generate(firmware, coefficients, sha256, &asked)?;
    Ok((generated, options))
}

/// Refuses to compile what other firmware computes.
pub(super) fn not_compiled(arguments: &Arguments) -> Result<()> {
    match arguments.firmware {
        Some(_) => {
            Err(refused!("verify compiles what was generated, and the firmware of --for is not part of it")
                .mend("compare the files with check"))
        }
        None => Ok(()),
    }
}
