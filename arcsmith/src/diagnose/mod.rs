//! `diagnose`: reads, runs the recordings in parallel, writes.

pub mod motion;
pub mod summary;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use codegen::refused;
use diagnosis::effects::{Effect, declared};
use diagnosis::observe::{Simulated, Wanted};
use diagnosis::{Diagnosis, Options, Outcome, diagnose, effects, report, simulated};
use fitter::output::FileSet;
use fitter::recording::{Note, Purpose, Reading};
use fitter::{Mirror, Recording, Sensor, text_safety};
use pages::Beside;
use rayon::prelude::*;

use crate::fit::MapArgs;
use crate::next;
use crate::terminal::{Common, Result, line, summarise, warn};
use codegen::cli::recording;

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith diagnose calibration.csv --mirror mirror.toml --out diagnosis
  arcsmith diagnose monday.csv tuesday.csv --mirror mirror.toml --out diagnosis --no-report
  arcsmith diagnose calibration.csv --mirror mirror.toml --held-out verification.csv --out diagnosis
  arcsmith diagnose calibration.csv --mirror mirror.toml --effects mine.toml --out diagnosis
  arcsmith diagnose motion.csv --plant plant.toml --map position=Encoder:deg --out diagnosis
  arcsmith diagnose calibration.csv --mirror mirror.toml --out diagnosis --json | jq .[0].verdict";

/// More threads than this for every processor bring nothing.
const MOST_THREADS_PER_PROCESSOR: usize = 4;

/// What is stated of the device and of its recordings.
#[derive(Args)]
pub struct DeviceArgs {
    /// The nominal mirror (mirror.toml), for static calibration recordings
    #[arg(long, required_unless_present = "plant", conflicts_with = "plant")]
    pub mirror: Option<PathBuf>,
    /// The nominal plant (plant.toml), for dynamic recordings
    #[arg(long)]
    pub plant: Option<PathBuf>,
    /// Effects of your own (TOML), which take part beside the catalogue: in calibrations, and in motion beside a second-order plant or one in equations
    #[arg(long, value_name = "FILE")]
    pub effects: Option<PathBuf>,
    #[command(flatten)]
    pub map: MapArgs,
    /// Leave these effects out of the catalogue (ids, separated by commas)
    #[arg(long, value_delimiter = ',')]
    pub without: Vec<String>,
}

impl DeviceArgs {
    /// As they are typed.
    pub fn typed(&self) -> String {
        let files = [("mirror", &self.mirror), ("plant", &self.plant), ("effects", &self.effects)];
        next::device(&files.map(|(name, path)| (name, path.as_deref())), &self.map.typed(), &self.without)
    }
}

/// Arguments of `diagnose`.
#[derive(Args)]
pub struct Arguments {
    /// The recordings (CSV, CSV.gz, or Parquet; `-`: standard input)
    #[arg(required = true, value_parser = recording())]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
    /// The folder to write into; it is made if it is not there
    #[arg(long)]
    out: PathBuf,
    /// Another recording of the same device, for the held-out figures
    #[arg(long)]
    held_out: Option<PathBuf>,
    /// Your own simulation of the same rows (t_s and the predicted reference), instead of the built-in one
    #[arg(long)]
    simulated: Option<PathBuf>,
    /// Write no HTML report
    #[arg(long)]
    no_report: bool,
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
    jobs: Option<usize>,
}

pub fn run(cli: &Arguments, common: Common) -> Result<()> {
    match (&cli.device.mirror, &cli.device.plant) {
        (_, Some(plant)) => motion::run(cli, plant, common),
        (Some(mirror), None) => run_static(cli, mirror, common),
        (None, None) => Err(refused!("--mirror is missing").mend("give the mirror.toml")),
    }
}

fn run_static(cli: &Arguments, mirror: &Path, common: Common) -> Result<()> {
    let mirror = Mirror::read(mirror)?;
    let stems = stems(&cli.recordings)?;
    let declared = declared(&mirror.sensor, cli.device.effects.as_deref(), &cli.device.without)?;
    one_simulation(cli)?;
    let reading =
        Reading { purpose: Purpose::Fit, mappings: &cli.device.map.map, sensor: Some(&mirror.sensor) };
    let read = |path: &Path| Recording::read_as(path, &reading, &mut |_| {});
    let held_out = cli.held_out.as_deref().map(read).transpose()?;
    let simulated = cli.simulated.as_deref().map(simulated::read).transpose()?;
    // Everything is read before anything is computed, and computed before anything is written.
    let recordings: Vec<Recording> =
        cli.recordings.iter().map(|path| read(path)).collect::<Result<_, _>>()?;
    recordings.iter().for_each(|recording| tell_times(&recording.file, &recording.notes, common));
    let options = Options {
        skip: cli.device.without.clone(),
        declared,
        base: Wanted {
            order: cli.order.map(usize::from),
            turn_harmonics: cli.turn_harmonics.map(usize::from),
        },
        harmonics: cli.harmonics.map(usize::from),
        forced: false,
        command: command(cli),
    };
    let outcomes = all(cli, common, &recordings, |recording| {
        let simulated: Option<Simulated> =
            simulated.as_ref().map(|s| s.for_recording(recording)).transpose()?;
        Ok(diagnose(recording, &mirror, simulated.as_ref(), held_out.as_ref(), &options)?)
    })?;
    let mut set = FileSet::new();
    set.folder(&cli.out)?;
    for (stem, outcome) in stems.iter().zip(&outcomes) {
        write(&mut set, cli, stem, outcome)?;
    }
    set.commit()?;
    tell(outcomes.iter().map(|outcome| &outcome.diagnosis), &cli.out, common);
    Ok(())
}

/// Warns where points in time stand for seconds.
fn tell_times(file: &str, notes: &[Note], common: Common) {
    for note in notes.iter().filter(|note| matches!(note, Note::Timestamps { .. })) {
        warn(&format!("{file}: {note}"), common);
    }
}

/// The effects that are declared in a file, which take part beside the catalogue; refuses `without` to name what is in
/// neither.
pub fn declared(sensor: &Sensor, effects: Option<&Path>, without: &[String]) -> Result<Vec<Effect>> {
    let declared = effects.map(|path| declared::read_file(path, sensor)).transpose()?.unwrap_or_default();
    let catalogued = effects::catalogue(sensor);
    let ids = catalogued.iter().chain(&declared).map(|effect| effect.id.as_str());
    known(without, &ids.collect::<Vec<_>>())?;
    Ok(declared)
}

/// What is made of every recording, several at a time, in their order.
fn all<R: Sync, O: Send>(
    cli: &Arguments,
    common: Common,
    recordings: &[R],
    one: impl Fn(&R) -> Result<O> + Sync,
) -> Result<Vec<O>> {
    let template = match recordings.len() {
        ..10 => "{spinner} diagnosing, {elapsed}",
        _ => "{bar:40} {pos}/{len} recordings, {eta} left",
    };
    let bar = common.progress(recordings.len() as u64, template);
    let outcomes: Vec<Result<O>> = threads(cli.jobs)?.install(|| {
        let diagnosed = |recording| {
            let outcome = one(recording);
            bar.inc(1);
            outcome
        };
        recordings.par_iter().map(diagnosed).collect()
    });
    bar.finish_and_clear();
    outcomes.into_iter().collect()
}

/// Prints what was found.
fn tell<'a>(found: impl Iterator<Item = &'a Diagnosis>, out: &Path, common: Common) {
    let found: Vec<&Diagnosis> = found.collect();
    summarise(
        common,
        || serde_json::to_value(&found).unwrap_or_default(),
        || {
            let texts: Vec<String> = found.iter().map(|one| summary::styled(one, common.verbose)).collect();
            texts.concat() + &line("written", &out.display().to_string())
        },
    );
}

/// Refuses one simulation for several recordings.
fn one_simulation(cli: &Arguments) -> Result<()> {
    if cli.simulated.is_none() || cli.recordings.len() == 1 {
        return Ok(());
    }
    let found = cli.recordings.len();
    Err(refused!("--simulated belongs to the rows of one recording")
        .found(format_args!("{found} recordings"))
        .expected("one"))
}

/// The name of a recording's output files: its own, without `.csv` and `.gz`.
pub fn stem(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.strip_suffix(".csv").unwrap_or(name).to_string()
}

/// The stems of the output files; equal ones would overwrite each other.
fn stems(paths: &[PathBuf]) -> Result<Vec<String>> {
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    let mut stems = Vec::new();
    for path in paths {
        let stem = stem(path);
        if let Some(first) = seen.insert(stem.clone(), path) {
            let (first, path) = (first.display(), path.display());
            return Err(refused!("{first} and {path}: both would be written as `{stem}`")
                .mend("rename one or diagnose them in separate calls"));
        }
        stems.push(stem);
    }
    Ok(stems)
}

/// Refuses ids that no effect has.
fn known(ids: &[String], all: &[&str]) -> Result<()> {
    match ids.iter().find(|id| !all.contains(&id.as_str())) {
        None => Ok(()),
        Some(id) => Err(refused!("--without names no effect of the catalogue")
            .cell(id)
            .expected(format_args!("one of {}", all.join(", ")))),
    }
}

/// As many threads as wanted, one per processor where nothing is said; more than a few per processor bring nothing.
pub fn threads(wanted: Option<usize>) -> Result<rayon::ThreadPool> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let count = wanted.unwrap_or(processors).clamp(1, MOST_THREADS_PER_PROCESSOR * processors);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    pool.map_err(|error| {
        refused!("{count} threads could not be started ({error})").mend("ask for fewer").by("jobs")
    })
}

/// The command as it stands in the coefficients file: without folders, which differ from machine to machine.
fn command(cli: &Arguments) -> String {
    let name = |p: &Path| text_safety::file_name(p);
    let recordings: Vec<String> = cli.recordings.iter().map(|p| name(p)).collect();
    let mirror = cli.device.mirror.as_deref().map_or_else(String::new, name);
    let harmonics = cli.harmonics.map_or_else(String::new, |n| format!(" --harmonics {n}"));
    let order = cli.order.map_or_else(String::new, |n| format!(" --order {n}"));
    let turn = cli.turn_harmonics.map_or_else(String::new, |n| format!(" --turn-harmonics {n}"));
    let map: String = cli.device.map.map.iter().map(|mapping| format!(" --map '{mapping}'")).collect();
    let command = format!("diagnose {} --mirror {mirror}{map}{order}{turn}{harmonics}", recordings.join(" "));
    text_safety::command(&command)
}

/// Adds the files of one recording, the answer last: it names the others.
fn write(set: &mut FileSet, cli: &Arguments, stem: &str, outcome: &Outcome) -> Result<()> {
    let at = |end: &str| cli.out.join(format!("{stem}.{end}"));
    let coefficients = at("coefficients.json");
    if !cli.no_report {
        let out = next::quoted_path(&cli.out);
        let again = format!("arcsmith diagnose NEXT.csv{} --out {out}", cli.device.typed());
        let mut written = vec![at("html"), at("json")];
        written.extend(outcome.coefficients.as_ref().map(|_| coefficients.clone()));
        let beside = Beside {
            next: next::after_diagnosis(outcome.coefficients.as_ref(), &coefficients, &again),
            written: written.iter().map(|path| text_safety::path(path)).collect(),
        };
        set.put(&at("html"), report::page(outcome, &beside))?;
    }
    match &outcome.coefficients {
        Some(file) => set.put(&coefficients, file.to_sealed_json())?,
        // A file of an earlier run would pass for this one's.
        None => set.remove(&coefficients)?,
    }
    let text = serde_json::to_string_pretty(&outcome.diagnosis)? + "\n";
    Ok(set.put(&at("json"), text)?)
}
