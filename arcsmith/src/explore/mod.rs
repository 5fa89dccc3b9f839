//! `explore`: the Pareto-optimal routines.

mod plot;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use codegen::cli::{Arguments, designing, options, source};
use codegen::cost::Core;
use codegen::quantity::Quantity;
use codegen::{explore, files, refused, text};
use fitter::output;

use crate::terminal::{FIGURE, LABEL, Result, summarise};

/// Arguments of `explore`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith explore --demo --target cortex-m0
  arcsmith explore --coefficients coefficients.json --format q31,q15 --svg bounds.svg
  arcsmith explore --demo --json | jq '.[0]'")]
pub struct ExploreArgs {
    #[command(flatten)]
    arguments: Arguments,
    /// Also draw the bounds against the instructions, as an SVG picture.
    #[arg(long)]
    svg: Option<PathBuf>,
}

pub fn run(arguments: &ExploreArgs) -> Result<ExitCode> {
    let common = &arguments.arguments;
    let bar = common.progress();
    if common.firmware.is_some() {
        return Err(refused!("explore lists routines, and --for makes a table").mend("leave it out"));
    }
    if !common.devices.is_empty() {
        return Err(refused!("explore does not go with --devices").mend("leave it out"));
    }
    source::tell(common)?;
    if let Some(svg) = &arguments.svg {
        output::not_the_input(svg, &source::source(common)?.files())?;
    }
    let (coefficients, _) = common.load()?;
    if coefficients.whole_turn() {
        return Err(refused!(
            "the coefficients are an encoder's: `generate` takes the cheapest of its routines; `explore` \
             lists those of other sensors"
        ));
    }
    let unit = Quantity::of(&coefficients.error_model()).bound_unit;
    let options = options::options(common, &unit, !coefficients.terms.is_empty())?;
    let candidates = explore::candidates(
        &coefficients,
        &options,
        options::ends(common)?,
        &common.formats(),
        f64::MAX,
        &designing(&bar),
    )?;
    bar.finish_and_clear();
    let cores = common.target.map_or(Core::APART.to_vec(), |target| vec![target]);
    let rows = explore::rows(&candidates, &cores, &unit);
    if let Some(path) = &arguments.svg {
        let picture = plot::svg(&rows, &cores)?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = PathBuf::from(path.file_name().unwrap_or_default());
        files::write(folder, &[(name, picture)].into())?;
    }
    summarise(common.common, || serde_json::to_value(&rows).unwrap_or_default(), || table(&rows));
    Ok(ExitCode::SUCCESS)
}

/// The rows for people.
fn table(rows: &[explore::Row]) -> String {
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
