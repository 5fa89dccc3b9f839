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
    let mut given = options::of_other_sensors(a);
    given.extend(options::given(&[
        ("--target", a.target.is_some()),
        ("--flash-bytes", a.flash_bytes.is_some()),
        ("--output-bits", a.output_bits.is_some()),
        ("--name", a.name.is_some()),
        ("--bits", a.bits.is_some()),
        ("--counts", a.counts.is_some()),
        ("--source", a.source.is_some()),
        ("--entries", a.entries.is_some()),
        ("--ratio", a.ratio.is_some()),
    ]));
    let (name, takes) = (firmware.firmware().name(), firmware.firmware().takes());
    if let Some(option) = given.into_iter().find(|option| !takes.contains(option)) {
        return Err(refused!("{option} does not apply to a table of {name}").mend("leave it out"));
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

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::turn::fixtures::encoder;

    #[derive(Debug, Parser)]
    struct Generate {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn message(words: &str) -> String {
        // The file is named for the head alone.
        let words = words.split(' ').chain(["--coefficients", "encoder.json"]);
        let arguments = Generate::parse_from(words).arguments;
        let firmware = arguments.firmware.unwrap();
        prepare(&arguments, firmware, &encoder(360.0, 0.0, &[0.5, 0.0]), "").unwrap_err().to_string()
    }

    #[test]
    fn options_that_the_firmware_has_not_are_refused() {
        let usual = "generate --for moteus --counts 4096";
        for option in ["--entries 20", "--ratio 7", "--format q31", "--target cortex-m0", "--from 0 --to 90"]
        {
            let said = message(&format!("{usual} {option}"));
            let name = option.split(' ').next().unwrap();
            assert!(
                said.starts_with(name) && said.ends_with("does not apply to a table of moteus; leave it out"),
                "{said}"
            );
        }
        // What is allowed does not hide what is not.
        let said = message("generate --for linuxcnc --from 0 --to 90 --counts 4096");
        assert_eq!(said, "--counts does not apply to a table of linuxcnc; leave it out");
        let said = message("generate --for klipper --bound 0.001mm");
        assert!(said.contains("this sensor's is \"deg\""), "{said}");
    }

    #[test]
    fn the_counts_are_not_guessed() {
        let said = message("generate --for simplefoc");
        assert!(
            said.starts_with("the sensor's unit is deg; say how many bits the encoder's word has"),
            "{said}"
        );
    }
}
