//! The command line of `trials`.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use miette::{IntoDiagnostic, Result};
use serde::Serialize;
use trials::campaign::{Campaign, put};
use trials::report::Report;
use trials::score::Miss;
use trials::{dynamic, examples, real, summary};

/// Conceals physical effects in simulated recordings, has `diagnose` run on the recordings alone, and scores it.
#[derive(Parser)]
#[command(version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Static calibrations
    Static(Static),
    /// Moving mechanisms
    Dynamic(Dynamic),
}

#[derive(Args)]
struct Dynamic {
    /// Trials: a fifth of them nulls, the others with something concealed
    #[arg(long, default_value_t = 500)]
    trials: usize,
    /// Seed of everything: the same seed gives the same report
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all processors if not given
    #[arg(long)]
    jobs: Option<std::num::NonZeroUsize>,
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
    /// Seed of everything: the same seed gives the same report
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all processors if not given
    #[arg(long)]
    jobs: Option<std::num::NonZeroUsize>,
    /// The folder for recordings, answers and the report (report.json, report.html; examples.json and real.json
    /// where ARCSMITH_EXAMPLES and ARCSMITH_RECORDINGS name the folders of opened and of real recordings)
    #[arg(long, default_value = "target/trials")]
    out: PathBuf,
    /// Do not leave each effect out of the catalogue in turn
    #[arg(long)]
    skip_without: bool,
}

/// Runs the program; whether every figure was reached.
pub fn run(cli: &Cli) -> Result<bool> {
    match &cli.command {
        Command::Static(args) => run_static(args),
        Command::Dynamic(args) => run_dynamic(args),
    }
}

fn threads(jobs: Option<std::num::NonZeroUsize>) -> Result<usize> {
    match jobs {
        Some(jobs) => Ok(jobs.get()),
        None => Ok(std::thread::available_parallelism().into_diagnostic()?.get()),
    }
}

fn announce(hash: &str, count: usize) {
    println!("{count} recordings; the truth is sealed: SHA-256 {hash}");
}

fn tell_misses(misses: &[Miss]) {
    for miss in misses {
        println!("{}: {}: {} → {}", miss.recording, miss.figure, miss.concealed, miss.said);
    }
}

fn run_dynamic(args: &Dynamic) -> Result<bool> {
    let jobs = threads(args.jobs)?;
    let campaign =
        dynamic::campaign::Campaign { trials: args.trials, seed: args.seed, jobs, out: args.out.clone() };
    let outcome = campaign.run(announce).into_diagnostic()?;
    let report = dynamic::report::Report::new(&campaign, &outcome);
    report.write(&args.out).into_diagnostic()?;
    print!("{}", summary::table(&report.score.figures));
    println!(
        "{} answers that were not right are listed in {}",
        report.score.misses.len(),
        args.out.display()
    );
    let mut reached = summary::reached(&report.score.figures);
    if args.feedback > 0 {
        let folder = args.out.join("feedback");
        let figures = dynamic::feedback::run(args.feedback, args.seed, jobs, &folder).into_diagnostic()?;
        println!("\nUnder feedback");
        print!("{}", summary::table(&figures));
    }
    let opened = std::env::var_os("ARCSMITH_EXAMPLES").map(PathBuf::from);
    let scored = match &opened {
        Some(folder) => {
            dynamic::examples::score(folder, &args.out.join("examples"), jobs).into_diagnostic()?
        }
        None => None,
    };
    match scored {
        Some(scored) => {
            println!("\nOpened examples of an independent laboratory");
            print!("{}", summary::table(&scored.figures));
            tell_misses(&scored.misses);
            reached &= summary::reached(&scored.figures);
        }
        None => println!("\nOpened examples are skipped: ARCSMITH_EXAMPLES names no folder that holds them"),
    }
    Ok(reached)
}

fn run_static(args: &Static) -> Result<bool> {
    let jobs = threads(args.jobs)?;
    let campaign = Campaign {
        trials: args.trials,
        nulls: args.nulls,
        seed: args.seed,
        jobs,
        without: !args.skip_without,
        out: args.out.clone(),
    };
    let outcome = campaign.run(announce).into_diagnostic()?;
    let report = Report::new(&campaign, &outcome);
    report.write(&args.out).into_diagnostic()?;
    print!("{}", summary::table(&report.score.figures));
    println!(
        "{} answers that were not right are listed in {}",
        report.score.misses.len(),
        args.out.display()
    );
    let mut reached = summary::reached(&report.score.figures);

    if let Some(folder) = std::env::var_os("ARCSMITH_EXAMPLES") {
        let scored =
            examples::score(&PathBuf::from(folder), &args.out.join("examples"), jobs).into_diagnostic()?;
        put(&args.out.join("examples.json"), &json(&scored)?).into_diagnostic()?;
        println!("\nOpened examples of an independent laboratory");
        print!("{}", summary::table(&scored.figures));
        tell_misses(&scored.misses);
        reached &= summary::reached(&scored.figures);
    } else {
        println!("\nOpened examples are skipped: ARCSMITH_EXAMPLES names no folder");
    }
    match std::env::var_os("ARCSMITH_RECORDINGS") {
        Some(folder) => {
            let figures =
                real::figures(&PathBuf::from(folder), &args.out.join("real"), jobs).into_diagnostic()?;
            put(&args.out.join("real.json"), &json(&figures)?).into_diagnostic()?;
            println!("\nReal recordings");
            print!("{}", summary::table(&figures));
            reached &= summary::reached(&figures);
        }
        None => println!("\nReal recordings are skipped: ARCSMITH_RECORDINGS names no folder"),
    }
    Ok(reached)
}

fn json(value: &impl Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(value).into_diagnostic()? + "\n")
}
