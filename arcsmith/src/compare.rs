//! `compare`: reads two recordings, says what changed between them.

use std::path::PathBuf;

use clap::Args;
use codegen::cli::recording;
use diagnosis::compare::{Change, Comparison, Estimate, Kind, Quantity, compare};
use diagnosis::report::without_unit;
use diagnosis::{Options, report};
use fitter::figures::{figure, with_interval};
use fitter::output::FileSet;
use fitter::recording::{Purpose, Reading};
use fitter::{Mirror, Recording, text_safety};

use crate::diagnose::declared;
use crate::fit::MapArgs;
use crate::terminal::{Common, FIGURE, Result, WARNING, line, summarise};

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith compare march.csv november.csv --mirror mirror.toml --out comparison
  arcsmith compare healthy.csv suspect.csv --mirror mirror.toml --out comparison --json | jq .changes[0].id";

/// Arguments of `compare`.
#[derive(Args)]
pub struct CompareArgs {
    /// The earlier recording, or that of the healthy device (CSV, CSV.gz, or Parquet)
    #[arg(value_parser = recording())]
    then: PathBuf,
    /// The later one, or that of the suspect device
    #[arg(value_parser = recording())]
    now: PathBuf,
    /// The nominal mirror (mirror.toml)
    #[arg(long)]
    mirror: PathBuf,
    /// The folder to write into; it is made if it is not there
    #[arg(long)]
    out: PathBuf,
    /// Effects of your own (TOML), which take part beside the catalogue
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    #[command(flatten)]
    map: MapArgs,
    /// Write no HTML report
    #[arg(long)]
    no_report: bool,
    /// Leave these effects out of the catalogue (ids, separated by commas)
    #[arg(long, value_delimiter = ',')]
    without: Vec<String>,
}

pub fn run(args: &CompareArgs, common: Common) -> Result<()> {
    let mirror = Mirror::read(&args.mirror)?;
    let declared = declared(&mirror.sensor, args.effects.as_deref(), &args.without)?;
    let reading = Reading { purpose: Purpose::Fit, mappings: &args.map.map, sensor: Some(&mirror.sensor) };
    let read = |path: &PathBuf| Recording::read_as(path, &reading, &mut |_| {});
    let (then, now) = (read(&args.then)?, read(&args.now)?);
    let options = Options { skip: args.without.clone(), declared, ..Options::default() };
    let bar = common.progress(2, "{spinner} comparing, {elapsed}");
    let compared = compare(&then, &now, &mirror, &options);
    bar.finish_and_clear();
    let compared = compared?;
    let mut set = FileSet::new();
    set.folder(&args.out)?;
    let at = |end: &str| args.out.join(format!("compare.{end}"));
    if !args.no_report {
        let written = [at("html"), at("json")].map(|path| text_safety::path(&path));
        set.put(&at("html"), report::of_comparison(&compared, &written))?;
    }
    set.put(&at("json"), serde_json::to_string_pretty(&compared.comparison)? + "\n")?;
    set.commit()?;
    summarise(
        common,
        || serde_json::to_value(&compared.comparison).unwrap_or_default(),
        || styled(&compared.comparison, common.verbose) + &line("written", &args.out.display().to_string()),
    );
    Ok(())
}

/// What changed, on one screen; `verbose` leaves nothing out.
fn styled(c: &Comparison, verbose: bool) -> String {
    let style = if c.changes.is_empty() { FIGURE } else { WARNING };
    let mut text = format!("{style}{}{style:#}\n", report::compared(c));
    for change in &c.changes {
        text += &line("what", &described(change, &c.unit));
    }
    let [same, changed] = c.left.map(|left| figure(left, &c.unit));
    if !c.changes.is_empty() {
        text += &line("left now", &format!("rms {same} where nothing differs → {FIGURE}{changed}{FIGURE:#}"));
    }
    for seen in &c.would_have_seen {
        if verbose || seen.id == "new effect" || c.changes.is_empty() {
            text += &line("visible", &format!("{}: from {} rms on", seen.id, figure(seen.rms, &c.unit)));
        }
    }
    for note in &c.notes {
        text += &line("note", note);
    }
    text
}

fn described(change: &Change, unit: &str) -> String {
    let how = match change.kind {
        Kind::Came => " came",
        Kind::Went => " went",
        Kind::Moved => " changed",
        _ => "",
    };
    let of = |q: &Quantity| {
        let name = without_unit(&q.name, &q.unit);
        let value = |e: &Estimate| with_interval(e.value, e.ci95, &q.unit);
        match (&q.then, &q.now, &q.difference) {
            (Some(then), Some(now), _) => format!("{name} {} → {}", value(then), value(now)),
            (_, _, Some(difference)) => format!("{name} {}", value(difference)),
            _ => name.to_string(),
        }
    };
    let parameters: Vec<String> = change.parameters.iter().map(of).collect();
    let rms = change.rms.map_or_else(String::new, |rms| format!(", {} rms", figure(rms, unit)));
    let or = match change.alternatives.is_empty() {
        true => String::new(),
        false => format!(" (or {})", change.alternatives.join(", ")),
    };
    format!("{}{how}{or}{rms}: {}; p {:.1e}", change.id, parameters.join(", "), change.p_value)
}
