//! The command `explore`, and the choice that `--target` makes.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fitter::cli::common::{FIGURE, LABEL, summarise};
use fitter::coefficients::Coefficients;
use fitter::output;
use indicatif::ProgressBar;
use miette::{IntoDiagnostic, Result, miette};

use super::arguments::{Arguments, ExploreArguments};
use super::options::{self, ends};
use super::{load, progress, source};
use crate::choose::{self, Wanted};
use crate::cost::Core;
use crate::explore as front;
use crate::files;
use crate::format::Format;
use crate::options::Options;
use crate::plot;
use crate::quantity::Quantity;
use crate::text;
use crate::units::UnitsError;

/// The formats that the user named, or all that both languages have.
fn formats(arguments: &Arguments) -> Vec<Format> {
    match &arguments.format[..] {
        [] => choose::FORMATS.to_vec(),
        named => named.iter().map(|name| name.format()).collect(),
    }
}

/// Shows on the bar how many candidates of how many are through.
fn designing(bar: &ProgressBar) -> impl Fn(usize, usize) + Sync {
    bar.set_message("designing");
    move |through: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(through as u64);
    }
}

/// Puts the routine that `--target` asks for into the options.
pub(super) fn choose_for(
    core: Core,
    arguments: &Arguments,
    coefficients: &Coefficients,
    options: &mut Options,
    bar: &ProgressBar,
) -> Result<()> {
    let formats = formats(arguments);
    let wanted =
        Wanted { core, formats: &formats, ends: ends(arguments)?, flash_bytes: arguments.flash_bytes };
    choose::choose(coefficients, options, &wanted, &designing(bar)).map_err(|e| miette!("{e}"))
}

pub(super) fn explore(arguments: &ExploreArguments) -> Result<ExitCode> {
    let common = &arguments.arguments;
    let bar = progress(common);
    if !common.units.is_empty() {
        return Err(miette!("{}", UnitsError::Option { option: "explore" }));
    }
    source::tell(common)?;
    if let Some(svg) = &arguments.svg {
        output::not_the_input(svg, &source::source(common)?.files()).into_diagnostic()?;
    }
    let (coefficients, _) = load(common)?;
    if coefficients.whole_turn() {
        return Err(miette!(
            "the coefficients are an encoder's: `codegen` itself takes the cheapest of its routines; \
             `codegen explore` lists those of other sensors"
        ));
    }
    let unit = Quantity::of(&coefficients.error_model()).bound_unit;
    let options = options::options(common, &unit, !coefficients.terms.is_empty())?;
    let candidates = front::candidates(
        &coefficients,
        &options,
        ends(common)?,
        &formats(common),
        f64::MAX,
        &designing(&bar),
    )
    .map_err(|e| miette!("{e}"))?;
    bar.finish_and_clear();
    let cores = common.target.map_or(Core::ALL.to_vec(), |target| vec![target.core()]);
    let rows = front::rows(&candidates, &cores, &unit);
    if let Some(path) = &arguments.svg {
        let picture = plot::svg(&rows, &cores).into_diagnostic()?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = PathBuf::from(path.file_name().unwrap_or_default());
        files::write(folder, &[(name, picture)].into()).into_diagnostic()?;
    }
    summarise(common.common, || serde_json::to_value(&rows).unwrap_or_default(), || table(&rows));
    Ok(ExitCode::SUCCESS)
}

/// The rows for people.
fn table(rows: &[front::Row]) -> String {
    let (core, routine, bound) = ("core", "routine", "bound");
    let mut lines = format!(
        "{LABEL}{core:<11} {routine:<22} {bound:>14} {:>13} {:>7}{LABEL:#}\n",
        "instructions", "flash"
    );
    for row in rows {
        let bound = format!("{} {}", text::rounded_up(row.bound), row.unit);
        let (core, routine) = (row.core.name(), &row.routine);
        lines += &format!(
            "{core:<11} {routine:<22} {FIGURE}{bound:>14}{FIGURE:#} {:>13.0} {:>7}\n",
            row.instructions, row.flash_bytes
        );
    }
    lines
        + &format!(
            "\nBounds are proven. Instructions and flash (bytes) are estimates; instructions of counted routines\n\
             deviate by {:.0} % at most.",
            100.0 * Core::RELATIVE_ERROR
        )
}
