//! The command line of `diagnose`: reads, runs the recordings in parallel, writes. [`main`] is the program,
//! [`run`] its body for a program that takes the same [`Arguments`].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser};
use fitter::cli::common::{line, program, say, summarise};
use fitter::cli::{Common, MapArgs};
use fitter::output::FileSet;
use fitter::recording::{Purpose, Reading};
use fitter::text_safety;
use fitter::{Mirror, Recording};
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};
use rayon::prelude::*;

use crate::observe::{Simulated, Wanted};
use crate::simulated;
use crate::thresholds::cli::MOST_THREADS_PER_PROCESSOR;
use crate::{Diagnosis, Options, Outcome, diagnose, report, summary};

/// Locates where recordings differ from their simulation, names the physics, and shows that the fit improves.
#[derive(Parser)]
#[command(name = "diagnose", version, after_help = EXAMPLES)]
pub struct Cli {
    /// How much is said.
    #[command(flatten)]
    pub common: Common,
    /// What is diagnosed.
    #[command(flatten)]
    pub arguments: Arguments,
}

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  diagnose calibration.csv --mirror mirror.toml --out diagnosis
  diagnose monday.csv tuesday.csv --mirror mirror.toml --out diagnosis --no-report
  diagnose calibration.csv --mirror mirror.toml --held-out verification.csv --out diagnosis
  diagnose motion.csv --plant plant.toml --map position=Encoder:deg --out diagnosis
  diagnose calibration.csv --mirror mirror.toml --out diagnosis --json | jq .[0].verdict";

/// The program: parses the arguments, runs, and prints the message of what went wrong.
pub fn main() -> ExitCode {
    program(Cli::try_parse(), |cli| run(&cli.arguments, cli.common).map(|()| ExitCode::SUCCESS))
}

/// Arguments of `diagnose`.
#[derive(Args)]
pub struct Arguments {
    /// The recordings (CSV, CSV.gz, or Parquet; - is standard input)
    #[arg(required = true)]
    pub recordings: Vec<PathBuf>,
    /// The nominal mirror (mirror.toml), for static calibration recordings
    #[arg(long, required_unless_present = "plant", conflicts_with = "plant")]
    mirror: Option<PathBuf>,
    /// The nominal plant (plant.toml), for dynamic recordings
    #[arg(long)]
    plant: Option<PathBuf>,
    /// The folder to write into; it is made if it is not there
    #[arg(long, default_value_if("effects", "true", "."))]
    pub out: PathBuf,
    /// Print the catalogue of effects of static recordings (Markdown) and end
    #[arg(long, exclusive = true)]
    effects: bool,
    #[command(flatten)]
    pub(crate) map: MapArgs,
    /// Another recording of the same device, for the held-out figures
    #[arg(long)]
    pub held_out: Option<PathBuf>,
    /// Your own simulation of the same rows (t_s and the predicted reference), instead of the built-in one
    #[arg(long)]
    pub simulated: Option<PathBuf>,
    /// Write no HTML report
    #[arg(long)]
    pub no_report: bool,
    /// Leave these effects out of the catalogue (ids, separated by commas)
    #[arg(long, value_delimiter = ',')]
    pub without: Vec<String>,
    /// Hand on only this many harmonics of a periodic error, the strongest, fitted again without the others
    #[arg(long, value_name = "N", conflicts_with = "plant", value_parser = clap::value_parser!(u16).range(1..))]
    harmonics: Option<u16>,
    /// Order of the base polynomial; chosen by cross-validation if not given
    #[arg(long, value_name = "N", conflicts_with_all = ["plant", "turn_harmonics"], value_parser = clap::value_parser!(u16).range(1..=15))]
    order: Option<u16>,
    /// Harmonics of a whole turn in the base; chosen by cross-validation if not given
    #[arg(long, value_name = "N", conflicts_with = "plant", value_parser = clap::value_parser!(u16).range(0..=32))]
    turn_harmonics: Option<u16>,
    /// Number of threads; all processors if not given
    #[arg(long)]
    pub jobs: Option<usize>,
}

/// Runs the program.
///
/// # Errors
/// One message; nothing was written.
pub fn run(cli: &Arguments, common: Common) -> Result<()> {
    common.limit();
    if cli.effects {
        say(crate::effects::page::markdown().trim_end());
        return Ok(());
    }
    if let Some(plant) = &cli.plant {
        return crate::cli_dynamic::run(cli, plant, common);
    }
    let Some(mirror) = &cli.mirror else { return Err(miette!("--mirror is missing; give the mirror.toml")) };
    let mirror = Mirror::read(mirror).into_diagnostic()?;
    let stems = stems(&cli.recordings)?;
    known(&cli.without)?;
    if cli.simulated.is_some() && cli.recordings.len() > 1 {
        return Err(miette!(
            "--simulated: found {} recordings, expected one; a simulation belongs to the rows of one recording",
            cli.recordings.len()
        ));
    }
    let reading = Reading { purpose: Purpose::Fit, mappings: &cli.map.map, sensor: Some(&mirror.sensor) };
    let read = |path: &Path| Recording::read_as(path, &reading, &mut |_| {}).into_diagnostic();
    let held_out = cli.held_out.as_deref().map(read).transpose()?;
    let simulated = cli.simulated.as_deref().map(simulated::read).transpose().into_diagnostic()?;
    // Everything is read before anything is computed, and computed before anything is written.
    let recordings: Vec<Recording> = cli.recordings.iter().map(|path| read(path)).collect::<Result<_>>()?;
    let options = Options {
        skip: cli.without.clone(),
        base: Wanted {
            order: cli.order.map(usize::from),
            turn_harmonics: cli.turn_harmonics.map(usize::from),
        },
        harmonics: cli.harmonics.map(usize::from),
        command: command(cli),
    };
    let bar = progress(recordings.len(), common);
    let pool = threads(cli.jobs)?;
    let outcomes: Vec<Result<Outcome>> = pool.install(|| {
        recordings
            .par_iter()
            .map(|recording| {
                let outcome = one(recording, &mirror, simulated.as_ref(), held_out.as_ref(), &options);
                bar.inc(1);
                outcome
            })
            .collect()
    });
    bar.finish_and_clear();
    let outcomes: Vec<Outcome> = outcomes.into_iter().collect::<Result<_>>()?;
    let mut set = FileSet::new();
    set.folder(&cli.out).into_diagnostic()?;
    for (stem, outcome) in stems.iter().zip(&outcomes) {
        write(&mut set, &cli.out, stem, outcome, !cli.no_report)?;
    }
    set.commit().into_diagnostic()?;
    let outcomes: Vec<_> = outcomes.iter().map(|outcome| &outcome.diagnosis).collect();
    tell(&outcomes, &cli.out, common);
    Ok(())
}

/// Prints what was found.
pub(crate) fn tell(found: &[&Diagnosis], out: &Path, common: Common) {
    summarise(
        common,
        || serde_json::to_value(found).unwrap_or_default(),
        || {
            let texts: Vec<String> = found.iter().map(|one| summary::styled(one, common.verbose)).collect();
            texts.concat() + &line("written", &out.display().to_string())
        },
    );
}

fn one(
    recording: &Recording,
    mirror: &Mirror,
    simulated: Option<&simulated::Simulation>,
    held_out: Option<&Recording>,
    options: &Options,
) -> Result<Outcome> {
    let simulated: Option<Simulated> =
        simulated.map(|s| s.for_recording(recording)).transpose().into_diagnostic()?;
    diagnose(recording, mirror, simulated.as_ref(), held_out, options).into_diagnostic()
}

/// The stems of the output files; equal ones would overwrite each other.
pub(crate) fn stems(paths: &[PathBuf]) -> Result<Vec<String>> {
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    let mut stems = Vec::new();
    for path in paths {
        let path = if fitter::input::is_standard(path) { Path::new("stdin") } else { path };
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        let stem = name.strip_suffix(".csv").unwrap_or(name).to_string();
        if let Some(first) = seen.insert(stem.clone(), path) {
            return Err(miette!(
                "{} and {}: both would be written as `{stem}`; rename one or diagnose them in separate calls",
                first.display(),
                path.display()
            ));
        }
        stems.push(stem);
    }
    Ok(stems)
}

/// Refuses ids that no effect has.
fn known(ids: &[String]) -> Result<()> {
    let catalogue = crate::effects::catalogue();
    match ids.iter().find(|id| catalogue.iter().all(|e| e.id() != id.as_str())) {
        None => Ok(()),
        Some(id) => {
            let all: Vec<&str> = catalogue.iter().map(|e| e.id()).collect();
            Err(miette!("--without: found `{id}`, expected one of {}", all.join(", ")))
        }
    }
}

/// As many threads as wanted, one per processor where nothing is said; more than a few per processor bring nothing.
pub(crate) fn threads(wanted: Option<usize>) -> Result<rayon::ThreadPool> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let count = wanted.unwrap_or(processors).clamp(1, MOST_THREADS_PER_PROCESSOR * processors);
    rayon::ThreadPoolBuilder::new().num_threads(count).build().into_diagnostic()
}

/// The command as it stands in the coefficients file: without folders, which differ from machine to machine.
fn command(cli: &Arguments) -> String {
    let name = |p: &Path| text_safety::file_name(p);
    let recordings: Vec<String> = cli.recordings.iter().map(|p| name(p)).collect();
    let mirror = cli.mirror.as_deref().map_or_else(String::new, name);
    let harmonics = cli.harmonics.map_or_else(String::new, |n| format!(" --harmonics {n}"));
    let order = cli.order.map_or_else(String::new, |n| format!(" --order {n}"));
    let turn = cli.turn_harmonics.map_or_else(String::new, |n| format!(" --turn-harmonics {n}"));
    let map: String = cli.map.map.iter().map(|mapping| format!(" --map '{mapping}'")).collect();
    let command = format!("diagnose {} --mirror {mirror}{map}{order}{turn}{harmonics}", recordings.join(" "));
    text_safety::command(&command)
}

/// Adds the files of one recording, the answer last: it names the others.
fn write(set: &mut FileSet, folder: &Path, stem: &str, outcome: &Outcome, with_report: bool) -> Result<()> {
    let at = |end: &str| folder.join(format!("{stem}.{end}"));
    if with_report {
        set.put(&at("html"), report::page(outcome)).into_diagnostic()?;
    }
    let coefficients = at("coefficients.json");
    match &outcome.coefficients {
        Some(file) => set.put(&coefficients, file.to_sealed_json()).into_diagnostic()?,
        // A file of an earlier run would pass for this one's.
        None => set.remove(&coefficients).into_diagnostic()?,
    }
    let text = serde_json::to_string_pretty(&outcome.diagnosis).into_diagnostic()? + "\n";
    set.put(&at("json"), text).into_diagnostic()
}

/// Progress on standard error: how many recordings are through, or, of a few, that something goes on.
pub(crate) fn progress(count: usize, common: Common) -> ProgressBar {
    if !common.watched() {
        return ProgressBar::hidden();
    }
    let template = if count < 10 {
        "{spinner} diagnosing, {elapsed}"
    } else {
        "{bar:40} {pos}/{len} recordings, {eta} left"
    };
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    bar
}
