//! `trials`: exit code 0 where every figure is reached, 1 where one is not.

mod summary;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use codegen::refused;
use serde::Serialize;
use serde_json::json;
use trials::plan::{Counts, cells};
use trials::programs::Programs;
use trials::report::Report;
use trials::workspace::{Campaign, put};
use trials::{beyond, budget, compare, dynamic, examples, fleet, real};

use crate::terminal::{Common, Result, Watched, called};
use summary::Summary;

/// Arguments of `trials`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith trials static                                              3000 trials and 8000 nulls: an hour or two
  arcsmith trials static --trials 300 --nulls 50 --skip-without       some minutes
  arcsmith trials static --trials 0 --nulls 0 --coverage 400 --only local_defect --only sensor_clipping
  arcsmith trials static --trials 0 --nulls 0 --twice 1000            some minutes
  arcsmith trials dynamic --trials 50 --seed 2 --json
  arcsmith trials beyond --trials 6 --nulls 0 --seed 5                a minute or two
  arcsmith trials budget --devices 100                                a minute or two
  arcsmith trials compare --pairs 50 --nulls 100 --motion 0 --feedback 0  a minute or two
  arcsmith trials fleet --pooled 6 --weak 1 --nulls 10                a minute or two")]
pub struct TrialsArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Static calibrations
    Static(Static),
    /// Moving mechanisms
    Dynamic(Dynamic),
    /// Calibrations with physics that the catalogue lacks: what is handed on is tried on a fresh recording
    Beyond(Beyond),
    /// Uncertainty budgets: whether the stated 95 % hold what corrected readings of simulated devices err by
    Budget(OfBudgets),
    /// Pairs of recordings of a device: what `compare` says changed, where nothing did, an effect moved, or one came
    Compare(OfPairs),
    /// Fleets: pooled means and spreads, effects too weak for one unit, false alarms of many units together
    Fleet(OfFleets),
}

/// What all trials take.
#[derive(Args)]
struct Running {
    /// Seed of everything: the same seed gives the same report
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all processors if not given
    #[arg(long)]
    jobs: Option<std::num::NonZeroUsize>,
}

impl Running {
    /// A campaign into a folder.
    fn campaign<C>(&self, counts: C, out: &Path) -> Result<Campaign<C>> {
        let jobs = match self.jobs {
            Some(jobs) => jobs,
            None => std::thread::available_parallelism()?,
        };
        Ok(Campaign { counts, seed: self.seed, jobs: jobs.get(), out: out.to_owned() })
    }
}

#[derive(Args)]
struct Beyond {
    /// Recordings of each kind of physics
    #[arg(long, default_value_t = 20)]
    trials: usize,
    /// Recordings of nothing in each of the eight noise families
    #[arg(long, default_value_t = 100)]
    nulls: usize,
    /// Recordings of each kind of physics in motion
    #[arg(long, default_value_t = 0)]
    motion: usize,
    /// Recordings of each effect of the catalogue, which is left out of it
    #[arg(long, default_value_t = 0)]
    leave_out: usize,
    /// This kind alone; may be repeated
    #[arg(long = "kind", value_name = "ID")]
    kinds: Vec<String>,
    #[command(flatten)]
    running: Running,
    /// The folder for recordings, answers and the report (report.json, report.md)
    #[arg(long, default_value = "target/trials-beyond")]
    out: PathBuf,
}

#[derive(Args)]
struct OfBudgets {
    /// Devices of each kind: mirrors, encoders, linear sensors
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..))]
    devices: u32,
    #[command(flatten)]
    running: Running,
    /// The folder for the report (budget.json)
    #[arg(long, default_value = "target/trials-budget")]
    out: PathBuf,
}

#[derive(Args)]
struct OfPairs {
    /// Pairs in which an effect moved, and as many in which one came
    #[arg(long, default_value_t = 400)]
    pairs: usize,
    /// Pairs in which nothing changed
    #[arg(long, default_value_t = 2000)]
    nulls: usize,
    /// Pairs of a mechanism in motion, of each of the three kinds
    #[arg(long, default_value_t = 200)]
    motion: usize,
    /// Pairs of a drive in its position loop, of each of the three kinds
    #[arg(long, default_value_t = 60)]
    feedback: usize,
    #[command(flatten)]
    running: Running,
    /// The folder for the report (compare.json)
    #[arg(long, default_value = "target/trials-compare")]
    out: PathBuf,
}

#[derive(Args)]
struct OfFleets {
    /// Fleets of an effect whose parameter scatters from unit to unit
    #[arg(long, default_value_t = 200)]
    pooled: usize,
    /// Fleets of 200 units with an effect of ρ 2 in each
    #[arg(long, default_value_t = 6)]
    weak: usize,
    /// Fleets of nothing
    #[arg(long, default_value_t = 400)]
    nulls: usize,
    /// Units of each other fleet
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u32).range(10..))]
    units: u32,
    #[command(flatten)]
    running: Running,
    /// The folder for recordings, results and the report (report.json)
    #[arg(long, default_value = "target/trials-fleet")]
    out: PathBuf,
}

#[derive(Args)]
struct Dynamic {
    /// Trials: a fifth of them nulls, the others with something concealed
    #[arg(long, default_value_t = 500)]
    trials: usize,
    #[command(flatten)]
    running: Running,
    /// Recordings under feedback besides, half of them nulls
    #[arg(long, default_value_t = 0)]
    feedback: usize,
    /// The folder for recordings, answers and the report (report.json, report.html; examples.json where
    /// ARCSMITH_EXAMPLES names the folder of opened recordings)
    #[arg(long, default_value = "target/trials-dynamic")]
    out: PathBuf,
}

#[derive(Args)]
struct Static {
    /// Trials with something concealed
    #[arg(long, default_value_t = 3000)]
    trials: usize,
    /// Nulls of each of the four noise families
    #[arg(long, default_value_t = 2000)]
    nulls: usize,
    /// Devices with one effect that is found for certain (ρ ≥ 8.2), for every effect in every schedule: how often its
    /// intervals hold the truth
    #[arg(long, default_value_t = 0)]
    coverage: usize,
    /// With --coverage: this effect alone; may be repeated
    #[arg(long, requires = "coverage")]
    only: Vec<String>,
    /// Devices with one to three effects of any strength that are recorded twice: how often the model of the first
    /// recording makes the second worse than the base alone
    #[arg(long, default_value_t = 0)]
    twice: usize,
    #[command(flatten)]
    running: Running,
    /// The folder for recordings, answers and the report (report.json, report.html; examples.json and real.json
    /// where ARCSMITH_EXAMPLES and ARCSMITH_RECORDINGS name the folders of opened and of real recordings)
    #[arg(long, default_value = "target/trials")]
    out: PathBuf,
    /// Do not leave each effect out of the catalogue in turn
    #[arg(long)]
    skip_without: bool,
}

pub fn run(args: &TrialsArgs, common: Common) -> Result<ExitCode> {
    let watch = Watched(common.progress(0, "{msg:17} {bar:40} {pos}/{len}, {eta} left"));
    let mut summary = Summary::new(common, watch.0.clone());
    let programs = Programs { path: own_path()?, watch: &watch };
    let reached = match &args.command {
        Command::Static(args) => run_static(args, &mut summary, &programs)?,
        Command::Dynamic(args) => run_dynamic(args, &mut summary, &programs)?,
        Command::Beyond(args) => run_beyond(args, &mut summary, &programs)?,
        Command::Budget(args) => run_budgets(args, &mut summary, &watch)?,
        Command::Compare(args) => run_pairs(args, &mut summary, &programs)?,
        Command::Fleet(args) => run_fleets(args, &mut summary, &programs)?,
    };
    watch.0.finish_and_clear();
    summary.end(reached);
    Ok(if reached { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// The file of this program: the path with which it was called, where it is a whole one. What runs may be another program
/// that holds this one.
fn own_path() -> std::io::Result<PathBuf> {
    let called = called().into_iter().next().map(PathBuf::from);
    called.filter(|path| path.is_absolute()).map_or_else(std::env::current_exe, Ok)
}

fn run_dynamic(args: &Dynamic, summary: &mut Summary, programs: &Programs) -> Result<bool> {
    let campaign = args.running.campaign(args.trials, &args.out)?;
    let outcome = campaign.run(programs, |hash, count| summary.sealed(hash, count))?;
    let report = Report::of_dynamic(&campaign, &outcome);
    report.write(&args.out)?;
    let mut reached = summary.campaign(&report.score.figures, report.score.misses.len(), &args.out);
    if args.feedback > 0 {
        let folder = args.out.join("feedback");
        let figures = dynamic::feedback::run(programs, args.feedback, campaign.seed, campaign.jobs, &folder)?;
        reached &= summary.set("Under feedback", &figures, &[]);
    }
    let opened = std::env::var_os("ARCSMITH_EXAMPLES").map(PathBuf::from);
    let scored = match &opened {
        Some(folder) => {
            dynamic::examples::score(programs, folder, &args.out.join("examples"), campaign.jobs)?
        }
        None => None,
    };
    match scored {
        Some(scored) => reached &= summary.set(OPENED, &scored.figures, &scored.misses),
        None => {
            summary.skipped("Opened examples are skipped: ARCSMITH_EXAMPLES names no folder that holds them")
        }
    }
    Ok(reached)
}

fn run_beyond(args: &Beyond, summary: &mut Summary, programs: &Programs) -> Result<bool> {
    let known = beyond::plan::kinds();
    if let Some(unknown) = args.kinds.iter().find(|id| !known.iter().any(|kind| kind.id == **id)) {
        let ids: Vec<&str> = known.iter().map(|kind| kind.id).collect();
        return Err(
            refused!("--kind {unknown}: found no such kind").mend(format!("take one of {}", ids.join(", ")))
        );
    }
    let counts = beyond::plan::Counts {
        trials: args.trials,
        motion: args.motion,
        left_out: args.leave_out,
        nulls: args.nulls,
        kinds: args.kinds.clone(),
    };
    let campaign = args.running.campaign(counts, &args.out)?;
    let outcome = campaign.run(programs, |hash, count| summary.sealed(hash, count))?;
    let report = Report::of_beyond(&campaign, &outcome);
    report.write(&args.out)?;
    Ok(summary.campaign(&report.score.figures, report.score.missed(), &args.out))
}

fn run_budgets(args: &OfBudgets, summary: &mut Summary, watch: &Watched) -> Result<bool> {
    let campaign = args.running.campaign(args.devices as usize, &args.out)?;
    let (mut reached, mut kinds) = (true, Vec::new());
    for kind in budget::Kind::ALL {
        let covered = budget::run(kind, campaign.counts, campaign.seed, campaign.jobs, watch)?;
        reached &= summary.set(kind.name(), &covered.figures(), &[]);
        kinds.push(covered);
    }
    std::fs::create_dir_all(&args.out)?;
    write(
        &args.out,
        "budget.json",
        &json!({"devices": args.devices, "seed": campaign.seed, "kinds": kinds}),
    )?;
    Ok(reached)
}

fn run_pairs(args: &OfPairs, summary: &mut Summary, programs: &Programs) -> Result<bool> {
    let OfPairs { pairs, nulls, motion, feedback, .. } = *args;
    let campaign = args.running.campaign((), &args.out)?;
    let (mut reached, mut kinds) = (true, Vec::new());
    for of in compare::Of::ALL {
        for kind in compare::Kind::ALL {
            let pairs = match (of, kind) {
                (compare::Of::Motion, _) => motion,
                (compare::Of::Feedback, _) => feedback,
                (_, compare::Kind::Same) => nulls,
                _ => pairs,
            };
            if pairs > 0 {
                let folder = std::path::absolute(&args.out)?.join(of.folder()).join(kind.folder());
                let compared =
                    compare::run(programs, (of, kind), pairs, campaign.seed, campaign.jobs, &folder)?;
                reached &= summary.set(kind.name(), &compared.figures(), &[]);
                kinds.push(compared);
            }
        }
    }
    std::fs::create_dir_all(&args.out)?;
    let report = json!({"seed": campaign.seed, "kinds": kinds});
    write(&args.out, "compare.json", &report)?;
    Ok(reached)
}

fn run_fleets(args: &OfFleets, summary: &mut Summary, programs: &Programs) -> Result<bool> {
    let OfFleets { pooled, weak, nulls, .. } = *args;
    let counts = fleet::Counts { pooled, weak, nulls, units: args.units as usize };
    let campaign = args.running.campaign(counts, &args.out)?;
    let measured = campaign.fleets(programs)?;
    write(&args.out, "report.json", &json!({"counts": counts, "seed": campaign.seed, "measured": measured}))?;
    Ok(summary.set("Fleets", &measured.figures(), &[]))
}

const OPENED: &str = "Opened examples of an independent laboratory";

fn run_static(args: &Static, summary: &mut Summary, programs: &Programs) -> Result<bool> {
    if let Some(unknown) = args.only.iter().find(|id| !cells().iter().any(|cell| cell.0 == **id)) {
        return Err(refused!("--only {unknown}: found no such effect").mend("`arcsmith effects` lists them"));
    }
    let counts = Counts {
        trials: args.trials,
        nulls: args.nulls,
        intervals: args.coverage,
        only: args.only.clone(),
        twice: args.twice,
        without: !args.skip_without,
    };
    let campaign = args.running.campaign(counts, &args.out)?;
    let jobs = campaign.jobs;
    let outcome = campaign.run(programs, |hash, count| summary.sealed(hash, count))?;
    let report = Report::of_static(&campaign, &outcome);
    report.write(&args.out)?;
    let mut reached = summary.campaign(&report.score.figures, report.score.misses.len(), &args.out);
    match std::env::var_os("ARCSMITH_EXAMPLES") {
        Some(folder) => {
            let scored = examples::score(programs, &PathBuf::from(folder), &args.out.join("examples"), jobs)?;
            write(&args.out, "examples.json", &scored)?;
            reached &= summary.set(OPENED, &scored.figures, &scored.misses);
        }
        None => summary.skipped("Opened examples are skipped: ARCSMITH_EXAMPLES names no folder"),
    }
    match std::env::var_os("ARCSMITH_RECORDINGS") {
        Some(folder) => {
            let figures = real::figures(programs, &PathBuf::from(folder), &args.out.join("real"), jobs)?;
            write(&args.out, "real.json", &figures)?;
            reached &= summary.set("Real recordings", &figures, &[]);
        }
        None => summary.skipped("Real recordings are skipped: ARCSMITH_RECORDINGS names no folder"),
    }
    Ok(reached)
}

fn write(folder: &Path, name: &str, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    Ok(put(&folder.join(name), &text)?)
}
