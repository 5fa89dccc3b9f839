//! `fleet`: many units of one kind, each diagnosed for itself, then all together.
//!
//! A part of the units is diagnosed (`source`, `answer`), becomes two tables (`table`, `parts`) and is written with the
//! `manifest`, so that a run that is killed goes on where it was. When all parts are there, they are read back (`results`),
//! pooled (`summary`) and shown (`page`).

pub mod answer;
pub mod choice;
mod lots;
mod manifest;
mod page;
mod parts;
mod results;
mod source;
mod summary;
pub mod table;

use std::path::{Path, PathBuf};

use clap::Args;
use codegen::refused;
use fitter::output::FileSet;
use fitter::text_safety;
use pages::Beside;

use crate::diagnose::threads;
use crate::fit::MapArgs;
use crate::next::{self, Step};
use crate::terminal::{Common, FIGURE, Result, WARNING, line, summarise};
use answer::{Asked, Unit};
use choice::Choice;
use manifest::{FILE, Manifest, Part, hash, paths};
use results::Results;
use source::{OfUnit, Source};
use summary::Summary;

/// Units of a part, where nothing is said: in memory they take some megabytes.
const UNITS_OF_PART: usize = 256;

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith fleet recordings --mirror mirror.toml --out results
  arcsmith fleet recordings --mirror mirror.toml --out results --resume
  arcsmith fleet production.parquet --unit serial --lot batch --mirror mirror.toml --out results
  arcsmith fleet recordings --lots lots.csv --mirror mirror.toml --out october --against september
  arcsmith fleet recordings --mirror mirror.toml --out results --json | jq .physics";

/// Arguments of `fleet`.
#[derive(Args)]
pub struct FleetArgs {
    /// A folder of recordings, one for each unit, which has the file's name; with --unit a Parquet file or a folder of them
    data: PathBuf,
    /// The nominal mirror (mirror.toml)
    #[arg(long)]
    mirror: PathBuf,
    /// The folder for the tables, the manifest, fleet.json and fleet.html
    #[arg(long)]
    out: PathBuf,
    /// The column of a Parquet dataset that names the unit of a row
    #[arg(long, value_name = "COLUMN")]
    unit: Option<String>,
    /// The column of a dataset that names the lot of a unit
    #[arg(long, value_name = "COLUMN", requires = "unit")]
    lot: Option<String>,
    /// The column of a dataset that holds the time of a unit, a number
    #[arg(long, value_name = "COLUMN", requires = "unit")]
    time: Option<String>,
    /// Lots of units: CSV with the columns `unit`, `lot` and, as wanted, `time`, a number
    #[arg(long, value_name = "FILE", conflicts_with_all = ["lot", "time"])]
    lots: Option<PathBuf>,
    /// The results of an earlier campaign, to tell what has changed since
    #[arg(long, value_name = "RESULTS")]
    against: Option<PathBuf>,
    /// Go on with what an earlier run left in --out
    #[arg(long)]
    resume: bool,
    /// Effects of your own (TOML), which take part beside the catalogue
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    #[command(flatten)]
    map: MapArgs,
    /// Leave these effects out of the catalogue (ids, separated by commas)
    #[arg(long, value_delimiter = ',')]
    without: Vec<String>,
    /// Hand on only this many harmonics of a periodic error, the strongest
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    harmonics: Option<u16>,
    /// Order of the base polynomial; chosen by cross-validation in each unit if not given
    #[arg(long, value_name = "N", conflicts_with = "turn_harmonics", value_parser = clap::value_parser!(u16).range(1..=15))]
    order: Option<u16>,
    /// Harmonics of a whole turn in the base; chosen by cross-validation in each unit if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=32))]
    turn_harmonics: Option<u16>,
    /// Units of each part of the tables
    #[arg(long, value_name = "N", default_value_t = UNITS_OF_PART as u32, value_parser = clap::value_parser!(u32).range(1..))]
    units_of_part: u32,
    /// Number of threads; all processors if not given
    #[arg(long)]
    jobs: Option<usize>,
}

pub fn run(args: &FleetArgs, common: Common) -> Result<()> {
    let choice = args.choice();
    let asked = choice.asked()?;
    let columns = OfUnit { unit: args.unit.as_deref(), lot: args.lot.as_deref(), time: args.time.as_deref() };
    let mut source = Source::find(&args.data, &columns)?;
    if let Some(file) = &args.lots {
        lots::tell(file, &mut source.units)?;
    }
    if args.out.join(FILE).exists() && !args.resume {
        return Err(refused!("holds results already")
            .at(&text_safety::path(&args.out))
            .mend("go on with them: --resume; or write into another folder"));
    }
    let earlier = args.against.as_deref().map(Results::of_folder).transpose()?;
    let new =
        Manifest::new(choice.hashed()?, data(&source.units), source.units.len(), args.units_of_part as usize);
    let mut manifest = new.continued(&args.out)?;
    args.work(&source, &asked, &mut manifest, common)?;
    let results = Results::read(&args.out, manifest.parts.len())?;
    let summary = Summary::of(&results, earlier.as_ref());
    let mut set = FileSet::new();
    let at = |name: &str| args.out.join(name);
    let beside = Beside {
        next: args.next(&summary, &source),
        written: ["fleet.html", "fleet.json", FILE].map(|name| text_safety::path(&at(name))).to_vec(),
    };
    set.put(&at("fleet.html"), page::page(&summary, &results, &beside))?;
    set.put(&at("fleet.json"), serde_json::to_string_pretty(&summary)? + "\n")?;
    set.commit()?;
    tell(&summary, &args.out, common);
    Ok(())
}

impl FleetArgs {
    fn choice(&self) -> Choice {
        Choice {
            mirror: self.mirror.clone(),
            effects: self.effects.clone(),
            mappings: self.map.map.clone(),
            without: self.without.clone(),
            harmonics: self.harmonics.map(usize::from),
            order: self.order.map(usize::from),
            turn_harmonics: self.turn_harmonics.map(usize::from),
            columns: [&self.unit, &self.lot, &self.time].map(Clone::clone),
        }
    }

    /// What the page proposes.
    fn next(&self, summary: &Summary, source: &Source) -> Vec<Step> {
        let file = |name: &str| source.units.iter().find(|unit| unit.name == name).map(|unit| &unit.file);
        let outlying = summary.outlying.first().filter(|_| self.unit.is_none());
        let outlying = outlying.and_then(|one| file(&one.unit)).map(|file| self.data.join(file));
        let files = [("mirror", Some(&*self.mirror)), ("effects", self.effects.as_deref())];
        next::after_fleet(
            outlying.as_deref(),
            &next::device(&files, &self.map.typed(), &self.without),
            &self.out,
        )
    }

    /// Diagnoses what is not there yet, part by part; each is written as soon as it is whole.
    fn work(&self, source: &Source, asked: &Asked, manifest: &mut Manifest, common: Common) -> Result<()> {
        let size = manifest.units_of_part;
        let of_part = |part: usize| part * size..((part + 1) * size).min(manifest.units);
        let missing: Vec<usize> =
            (0..manifest.parts.len()).filter(|part| manifest.parts[*part].is_none()).collect();
        let units: usize = missing.iter().map(|part| of_part(*part).len()).sum();
        let ranges: Vec<_> = missing.iter().map(|part| (*part, of_part(*part))).collect();
        let bar = common.progress(units as u64, "{bar:40} {pos}/{len} units, {per_sec}, {eta} left");
        let pool = threads(self.jobs)?;
        for (part, range) in ranges {
            let answers = pool.install(|| source.answers(range, asked, &|| bar.inc(1)))?;
            let files = [table::units(&answers, &manifest.options), table::parameters(&answers)];
            let [units, parameters] = files.map(|columns| parts::file(&columns));
            let [units, parameters] = [units?, parameters?];
            manifest.parts[part] = Some(Part { units: hash(&units), parameters: hash(&parameters) });
            let mut set = FileSet::new();
            for (path, bytes) in paths(&self.out, part).iter().zip([units, parameters]) {
                set.folder(path.parent().unwrap_or(&self.out))?;
                set.put(path, bytes)?;
            }
            // It vouches for the others.
            set.put(&self.out.join(FILE), serde_json::to_string_pretty(manifest)? + "\n")?;
            set.commit()?;
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// The hash of what is known of the units before their recordings are read.
fn data(units: &[Unit]) -> String {
    let one = |unit: &Unit| serde_json::json!([unit.name, unit.file, unit.lot, unit.time]).to_string();
    hash(units.iter().map(one).collect::<Vec<_>>().join("\n").as_bytes())
}

/// Prints what the fleet shows.
fn tell(summary: &Summary, out: &Path, common: Common) {
    summarise(
        common,
        || serde_json::to_value(summary).unwrap_or_default(),
        || styled(summary) + &line("written", &out.display().to_string()),
    );
}

/// So many effects and units are listed.
const LISTED: usize = 6;

fn styled(summary: &Summary) -> String {
    let verdicts: Vec<String> = summary
        .verdicts
        .iter()
        .map(|(verdict, count)| format!("{count} {}", verdict.replace('_', " ")))
        .collect();
    let mut text = format!("{FIGURE}{} units{FIGURE:#}: {}\n", summary.units, verdicts.join(", "));
    if let Some(first) = summary.failed.first() {
        let count = summary.failed.len();
        text += &line(
            "failed",
            &format!("{WARNING}{count}{WARNING:#}, the first {}: {}", first.unit, first.error),
        );
    }
    for one in summary.physics.iter().take(LISTED) {
        text += &line("named", &format!("{} in {} units, {:.0} %", one.effect, one.units, 100.0 * one.share));
    }
    for one in summary.parameters.iter().filter(|one| one.shown_by_fleet.is_some()) {
        text += &line("fleet", &page::sentence(one));
    }
    for one in summary.outlying.iter().take(LISTED) {
        text += &line(
            "departs",
            &format!(
                "{}: {} at {:.1} σ",
                one.unit,
                page::name(&one.effect, &one.parameter, &one.unit_of_measure),
                one.z
            ),
        );
    }
    text
}
