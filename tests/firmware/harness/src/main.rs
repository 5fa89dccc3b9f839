//! Builds firmware, runs it under QEMU, and compares or records what it costs.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};
use firmware_tests::measure::Part;
use firmware_tests::{Task, perform, tools};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Generated routines as firmware on Cortex-M0, M3, M4F, M7 and M33, under QEMU.
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
    /// Sweeps 1.07·10⁷ inputs of every case (a tenth of it through a soft-float library, and on Cortex-M0);
    /// compares digests, figures and the comparison with the committed ones.
    Check,
    /// Sweeps all 2³² inputs of every case on Cortex-M4F, in C by gcc and clang and in Rust: minutes for each.
    Exhaustive {
        /// Only a part of them, 1/64 to 64/64 for example.
        #[arg(long, default_value = "1/1")]
        part: Part,
    },
    /// Counts, and writes the table of figures and the comparison: everything that is committed here.
    Record,
    /// Counts what engineers write otherwise, and writes the comparison only.
    Compare,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let task = match cli.command {
        Command::Check => Task::Check,
        Command::Exhaustive { part } => Task::Exhaustive(part),
        Command::Record => Task::Record,
        Command::Compare => Task::Compare,
    };
    let bar = progress();
    let verdict = tools::find().and_then(|()| perform(task, &cli.case, cli.work.as_deref(), &bar));
    bar.finish_and_clear();
    match verdict {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
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
