//! Builds firmware, runs it under QEMU, and compares or records what it costs.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};
use firmware_tests::machine::Core;
use firmware_tests::measure::{self, Extent};
use firmware_tests::table::Table;
use firmware_tests::{cases, tools};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};

/// Generated routines as firmware on Cortex-M0, M3 and M4F, under QEMU.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Only cases whose name contains this.
    #[arg(long, global = true, default_value = "")]
    case: String,
    /// Keep everything that is built in this folder.
    #[arg(long, global = true)]
    work: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Command {
    /// Sweeps every 401st input and compares digests and figures; exit code 1 where they differ.
    Check,
    /// Sweeps all 2³² inputs of every case on Cortex-M4F (C by gcc and clang, Rust); takes hours with all cases.
    Exhaustive,
    /// Counts, and writes the table of figures.
    Record,
}

fn main() -> Result<ExitCode> {
    let cli = Cli::parse();
    tools::find().map_err(|e| miette!("{e}"))?;
    let cases: Vec<_> =
        cases::all().map_err(|e| miette!("{e}"))?.into_iter().filter(|c| c.name.contains(&cli.case)).collect();
    if cases.is_empty() {
        return Err(miette!("no case has {:?} in its name: see tests/firmware/cases.toml", cli.case));
    }
    let temporary = tempfile::tempdir().into_diagnostic()?;
    let work = cli.work.unwrap_or_else(|| temporary.path().to_path_buf());
    std::fs::create_dir_all(&work).into_diagnostic()?;
    let work = work.canonicalize().into_diagnostic()?;
    let bar = progress();
    let (cores, extent) = match cli.command {
        Command::Check => (&Core::ALL[..], Extent::Quick),
        Command::Exhaustive => (&[Core::M4f][..], Extent::Exhaustive),
        Command::Record => (&Core::ALL[..], Extent::None),
    };
    let is_part = !cli.case.is_empty();
    let found = measure::all(&cases, cores, extent, &work, &bar).map_err(|e| miette!("{e}"))?;
    bar.finish_and_clear();
    if matches!(cli.command, Command::Record) {
        let count = found.routines.len();
        found.merge_into(&Table::path(), is_part).map_err(|e| miette!("{e}"))?;
        println!("tests/firmware/instructions.json: {count} cases measured");
        return Ok(ExitCode::SUCCESS);
    }
    let committed = Table::read(&Table::path()).map_err(|e| miette!("{e}"))?;
    let verdict = committed.compare(&found, is_part, tools::is_ci()).map_err(|e| miette!("{e}"))?;
    println!("{verdict}");
    Ok(ExitCode::SUCCESS)
}

fn progress() -> ProgressBar {
    let bar = ProgressBar::hidden();
    if std::io::stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{elapsed_precise} {msg} {pos}/{len}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}
