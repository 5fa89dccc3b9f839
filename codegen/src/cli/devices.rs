//! `--devices`: one routine for many mirrors.

use std::process::ExitCode;

use serde_json::json;

use super::terminal::{FIGURE, line, summarise, warn};
use super::verify::conclude;
use super::{Arguments, Result, options};
use crate::devices::{self, Device, Generated, Wanted, verify};
use crate::files;
use crate::options::OutOfRange;
use crate::quantity::Quantity;
use crate::refused;
use crate::text;
use crate::verify::Checks;

/// Generates the files of the devices that are named.
fn prepare_all(arguments: &Arguments) -> Result<(Generated, Vec<Device>, Wanted)> {
    let a = arguments;
    let beside = [
        ("--target", a.target.is_some()),
        ("--flash-bytes", a.flash_bytes.is_some()),
        ("--table", a.table.is_some()),
        ("--output-bits", a.output_bits.is_some()),
        ("--counts", a.counts.is_some()),
        ("--out-of-range", a.out_of_range != OutOfRange::Clamp),
        ("--further", !a.further.is_empty()),
        ("--period-s", a.period_s.is_some()),
        ("--keep", !a.keep.is_empty()),
    ];
    if let Some((option, _)) = beside.into_iter().find(|(_, given)| *given) {
        return Err(refused!("{option} does not go with --devices").mend("leave it out"));
    }
    let bar = arguments.progress();
    let wanted = wanted(arguments)?;
    let paths = devices::expand(&arguments.devices)?;
    let devices = devices::read(&paths)?;
    let unit = devices.first().map(|device| Quantity::of(&device.coefficients.error_model()).bound_unit);
    let options = options::options(arguments, &unit.unwrap_or_default(), true)?;
    if options.routines.len() > 1 {
        return Err(refused!("--devices makes one routine").mend("give one --format, q31 or q31-split"));
    }
    bar.set_message("approximating and bounding");
    let generated = devices::generate(&devices, &options, &wanted)?;
    bar.finish_and_clear();
    Ok((generated, devices, wanted))
}

/// Generates the files.
pub(super) fn prepare(arguments: &Arguments) -> Result<Generated> {
    Ok(prepare_all(arguments)?.0)
}

/// Sweeps every device's page through the compiled files.
pub(super) fn verify(arguments: &Arguments, checks: &Checks) -> Result<ExitCode> {
    // `--exhaustive` would take minutes for every unit; what it asks for is proved.
    if let Some(option) = checks.beyond(&["--sanitize"]) {
        return Err(refused!("{option} does not go with --devices").mend("leave it out"));
    }
    let (generated, devices, wanted) = prepare_all(arguments)?;
    let bar = arguments.progress();
    bar.set_message("sweeping every unit");
    let report = verify::verify(&arguments.out, &generated, &devices, &wanted, checks.sanitize)?;
    bar.finish_and_clear();
    conclude(arguments, &report, report.holds(), &report.text())
}

fn wanted(arguments: &Arguments) -> Result<Wanted> {
    let usual = Wanted::default();
    let address = arguments.page_address.as_deref().map_or(Ok(usual.address), |given| {
        let digits = given.trim_start_matches("0x").trim_start_matches("0X");
        let parsed = if digits == given { given.parse() } else { u32::from_str_radix(digits, 16) };
        parsed.ok().filter(|address| address % 16 == 0).ok_or_else(|| {
            refused!("--page-address {given} is no place for a page")
                .mend("give a multiple of 16 below 2^32, for example 0x0801f800")
        })
    })?;
    let earlier = arguments.pages_for.as_deref().map(devices::earlier::read).transpose()?;
    Ok(Wanted { margin: arguments.margin.unwrap_or(usual.margin), address, earlier })
}

/// Generates and writes.
pub(super) fn write(arguments: &Arguments) -> Result<ExitCode> {
    let generated = prepare(arguments)?;
    let changed = files::write(&arguments.out, &generated.files)?;
    for open in generated.certificate.reservation.iter().flat_map(|open| open.lines()) {
        warn(open, arguments.common);
    }
    let design = &generated.design;
    let stated = |value: f64| {
        let unit = &design.shared.quantity.bound_unit;
        format!("{} {unit}", text::rounded_up(design.shared.quantity.in_bound_unit(value)))
    };
    let (out, count) = (arguments.out.display().to_string(), generated.files.len());
    summarise(
        arguments.common,
        || {
            json!({
                "routine": generated.name,
                "units": design.fitted.len(),
                "bound": stated(design.total),
                "rounding": stated(design.rounding),
                "out": out,
                "changed": changed,
            })
        },
        || {
            format!(
                "{:<24} degree {:>2}   {} units, each proven within {FIGURE}{}{FIGURE:#}, later ones within {}; any \
                 coefficients in their ranges: rounding {}\n",
                generated.name,
                design.degree,
                design.fitted.len(),
                stated(design.fitted.iter().map(|device| device.total).fold(0.0, f64::max)),
                stated(design.total),
                stated(design.rounding),
            ) + &line("written", &format!("{out}: {count} files, {changed} changed"))
        },
    );
    Ok(ExitCode::SUCCESS)
}
