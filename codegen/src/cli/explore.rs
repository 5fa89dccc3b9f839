//! The command `explore`, and the choice that `--target` makes.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fitter::coefficients::Coefficients;
use indicatif::ProgressBar;
use miette::{IntoDiagnostic, Result, miette};

use super::arguments::{Arguments, ExploreArguments};
use super::options::{self, ends};
use super::{load, progress};
use crate::cost::Core;
use crate::explore::{self as front, Candidate};
use crate::files;
use crate::format::Format;
use crate::options::{Options, RoutineOptions};
use crate::plot;
use crate::quantity::Quantity;
use crate::text;

/// All candidates of the formats that the user named, or of all formats that both languages have.
fn candidates(
    arguments: &Arguments,
    coefficients: &Coefficients,
    options: &Options,
    bar: &ProgressBar,
) -> Result<Vec<Candidate>> {
    let formats = match &arguments.format[..] {
        [] => vec![Format::Q31, Format::Q31Split, Format::Q15, Format::F32 { fused: false }],
        named => named.iter().map(|name| name.format()).collect(),
    };
    bar.set_message("designing");
    let done = |through: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(through as u64);
    };
    front::candidates(coefficients, options, ends(arguments)?, &formats, f64::MAX, &done)
        .map_err(|e| miette!("{e}"))
}

/// The routine that `--target` asks for; its degree is set in the options.
pub(super) fn chosen(
    arguments: &Arguments,
    core: Core,
    coefficients: &Coefficients,
    options: &mut Options,
    bar: &ProgressBar,
) -> Result<RoutineOptions> {
    let quantity = Quantity::of(&coefficients.error_model());
    let range = options.range.unwrap_or((coefficients.valid_range.from, coefficients.valid_range.to));
    let bound = options.bound.unwrap_or_else(|| quantity.default_bound(range.0, range.1));
    let candidates = candidates(arguments, coefficients, options, bar)?;
    let best = front::cheapest(&candidates, core, bound, arguments.flash_bytes, &quantity.bound_unit)
        .map_err(|e| miette!("{e}"))?;
    options.degree = Some(best.routine.design.degree);
    Ok(best.options.clone())
}

pub(super) fn explore(arguments: &ExploreArguments) -> Result<ExitCode> {
    let common = &arguments.arguments;
    let bar = progress(common);
    let (coefficients, _) = load(common)?;
    let unit = Quantity::of(&coefficients.error_model()).bound_unit;
    let options = options::options(common, &unit)?;
    let candidates = candidates(common, &coefficients, &options, &bar)?;
    bar.finish_and_clear();
    let cores = common.target.map_or(Core::ALL.to_vec(), |target| vec![target.core()]);
    let rows = front::rows(&candidates, &cores, &unit);
    if let Some(path) = &arguments.svg {
        let picture = plot::svg(&rows, &cores).into_diagnostic()?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = PathBuf::from(path.file_name().unwrap_or_default());
        files::write(folder, &[(name, picture)].into()).into_diagnostic()?;
    }
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&rows).into_diagnostic()?);
        return Ok(ExitCode::SUCCESS);
    }
    println!("{:<11} {:<22} {:>14} {:>13} {:>7}", "core", "routine", "bound", "instructions", "flash");
    for row in &rows {
        let bound = format!("{} {}", text::rounded_up(row.bound), row.unit);
        let (core, routine) = (row.core.name(), &row.routine);
        println!("{core:<11} {routine:<22} {bound:>14} {:>13.0} {:>7}", row.instructions, row.flash_bytes);
    }
    println!(
        "\nBounds are proven. Instructions and flash (bytes) are estimates; instructions of counted routines\n\
         deviate by {:.0} % at most.",
        100.0 * Core::RELATIVE_ERROR
    );
    Ok(ExitCode::SUCCESS)
}
