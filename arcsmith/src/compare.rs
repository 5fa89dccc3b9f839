//! `compare`: reads two recordings, says what changed between them.

use std::path::{Path, PathBuf};

use clap::Args;
use codegen::cli::recording;
use codegen::refused;
use diagnosis::compare::{Change, Compared, Comparison, Estimate, Kind, Points, Quantity, compare};
use diagnosis::dynamic::{Case, DynamicRecording};
use diagnosis::report::{probability, without_unit};
use diagnosis::{Options, report};
use fitter::figures::{figure, plain, with_interval};
use fitter::output::FileSet;
use fitter::plant::PlantFile;
use fitter::recording::{Purpose, Reading};
use fitter::{Mirror, Recording, text_safety};
use pages::Beside;

use crate::diagnose::{DeviceArgs, declared, motion};
use crate::next;
use crate::terminal::{Common, FIGURE, Result, WARNING, line, summarise};

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith compare march.csv november.csv --mirror mirror.toml --out comparison
  arcsmith compare new.csv worn.csv --plant plant.toml --out comparison
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
    #[command(flatten)]
    device: DeviceArgs,
    /// The folder to write into; it is made if it is not there
    #[arg(long)]
    out: PathBuf,
    /// Write no HTML report
    #[arg(long)]
    no_report: bool,
}

pub fn run(args: &CompareArgs, common: Common) -> Result<()> {
    let bar = common.progress(2, "{spinner} comparing, {elapsed}");
    let (comparison, points) = match (&args.device.mirror, &args.device.plant) {
        (_, Some(plant)) => (in_motion(args, plant)?, None),
        (Some(mirror), None) => of_calibrations(args, mirror)?,
        (None, None) => return Err(refused!("--mirror is missing").mend("give the mirror.toml")),
    };
    bar.finish_and_clear();
    let mut set = FileSet::new();
    set.folder(&args.out)?;
    let at = |end: &str| args.out.join(format!("compare.{end}"));
    if !args.no_report {
        let beside = Beside {
            next: next::after_comparison(&args.now, &args.device.typed(), comparison.changes.is_empty()),
            written: [at("html"), at("json")].map(|path| text_safety::path(&path)).to_vec(),
        };
        set.put(&at("html"), report::of_comparison(&comparison, points.as_ref(), &beside))?;
    }
    set.put(&at("json"), serde_json::to_string_pretty(&comparison)? + "\n")?;
    set.commit()?;
    summarise(
        common,
        || serde_json::to_value(&comparison).unwrap_or_default(),
        || styled(&comparison, common.verbose) + &line("written", &args.out.display().to_string()),
    );
    Ok(())
}

fn of_calibrations(args: &CompareArgs, mirror: &Path) -> Result<(Comparison, Option<Points>)> {
    let mirror = Mirror::read(mirror)?;
    let declared = declared(&mirror.sensor, args.device.effects.as_deref(), &args.device.without)?;
    let reading =
        Reading { purpose: Purpose::Fit, mappings: &args.device.map.map, sensor: Some(&mirror.sensor) };
    let read = |path: &Path| Recording::read_as(path, &reading, &mut |_| {});
    let (then, now) = (read(&args.then)?, read(&args.now)?);
    let options = Options { skip: args.device.without.clone(), declared, ..Options::default() };
    let Compared { comparison, points, .. } = compare(&then, &now, &mirror, &options)?;
    Ok((comparison, Some(points)))
}

fn in_motion(args: &CompareArgs, plant: &Path) -> Result<Comparison> {
    let file = PlantFile::read(plant)?;
    let name = text_safety::path(plant);
    let options = motion::options(plant, &file, args.device.effects.as_deref(), &args.device.without)?;
    let reading = motion::reading(&file, &args.device.map.map);
    let then = DynamicRecording::read(&args.then, &reading)?;
    let now = DynamicRecording::read(&args.now, &reading)?;
    let case = Case {
        recording: &then,
        plant: &file,
        plant_file: &name,
        simulated: None,
        held_out: None,
        options: &options,
    };
    Ok(diagnosis::compare::motion::compare(&case, &now)?)
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
            let rms = seen.rms.map(|rms| format!("from {} rms on", figure(rms, &c.unit)));
            let parameter =
                seen.parameter.as_ref().map(|(name, value)| format!("{name} from {} on", plain(*value)));
            let what: Vec<String> = [rms, parameter].into_iter().flatten().collect();
            text += &line("visible", &format!("{}: {}", seen.id, what.join(", ")));
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
            (_, _, Some(one)) | (Some(one), ..) | (_, Some(one), _) => format!("{name} {}", value(one)),
            _ => name.to_string(),
        }
    };
    let parameters: Vec<String> = change.parameters.iter().map(of).collect();
    let rms = change.rms.map_or_else(String::new, |rms| format!(", {} rms", figure(rms, unit)));
    let or = match change.alternatives.is_empty() {
        true => String::new(),
        false => format!(" (or {})", change.alternatives.join(", ")),
    };
    format!("{}{how}{or}{rms}: {}; p {}", change.id, parameters.join(", "), probability(change.p_value))
}
