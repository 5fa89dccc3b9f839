//! The command line of `twin`: simulates recordings and writes them. [`main`] is the program, [`run`] its body
//! for a program that takes the same [`Command`]s in.

mod encode;
mod moving;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};
use fitter::cli::Common;
use fitter::cli::common::{FIGURE, program, summarise};
use miette::{IntoDiagnostic, Result, miette};
use serde_json::json;

use crate::dynamic::effects as moving_effects;
use crate::{Device, Injected, Noise, Protocol, Temperature, effects};

/// Simulates a scanning mirror: its calibration, and its motion.
#[derive(Parser)]
#[command(name = "twin", version, after_help = EXAMPLES)]
pub struct Cli {
    /// How much is said.
    #[command(flatten)]
    pub common: Common,
    /// What is done.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  twin record --protocol calibration --seed 7 --out calibration.csv
  twin encode --seed 7 --unit counts --out encoder.csv
  twin excite --seed 7 --excitation sweep --out motion.csv
  twin simulate --plant motion.plant.toml --drive motion.csv --out simulated.csv";

/// The commands.
#[derive(Subcommand)]
pub enum Command {
    /// Step a mirror through a calibration in closed loop on the calculated angle, and write its log
    #[command(after_help = RECORD)]
    Record(Record),
    /// Turn a magnetic encoder against a reference, and write what both read
    #[command(after_help = ENCODE)]
    Encode(encode::Encode),
    /// Excite a mirror, and write drive and position
    #[command(after_help = EXCITE)]
    Excite(moving::Excite),
    /// Run a plant, with all that was found in it, on the drive of a recording, and write the position
    #[command(after_help = SIMULATE)]
    Simulate(moving::Simulate),
    /// List the effects that can be hidden in a device, with their parameters
    Effects,
}

const RECORD: &str = "\
Examples:
  twin record --protocol calibration --seed 7 --out calibration.csv
  twin record --protocol verification --device-seed 7 --seed 8 --out verification.csv
  twin record --protocol calibration --seed 7 --temperature levels \\
      --effect thermal_zero_drift:coefficient_arcsec_per_k=0.2 --out warm.csv";

const ENCODE: &str = "\
Examples:
  twin encode --seed 7 --out encoder.csv
  twin encode --seed 7 --unit counts --turns 3 --out counts.csv.gz";

const EXCITE: &str = "\
Examples:
  twin excite --seed 7 --out motion.csv
  twin excite --seed 7 --excitation sweep --runs 4 --effect cubic_stiffness:coefficient=3e-7 --out motion.csv.gz";

const SIMULATE: &str = "\
Examples:
  twin simulate --plant motion.plant.toml --drive motion.csv --out simulated.csv
  twin simulate --plant plant.toml --drive motion.csv --begin rest --out simulated.csv";

/// Arguments of `twin record`.
#[derive(Args)]
pub struct Record {
    /// calibration: ±1.7° in steps of 0.1°; verification: ±1.4° in steps of 0.2°; six passes each.
    #[arg(long, value_enum)]
    protocol: Kind,
    /// Seed of the recording.
    #[arg(long)]
    seed: u64,
    /// Seed of the device, where it is not that of the recording: the same device recorded again.
    #[arg(long)]
    device_seed: Option<u64>,
    /// The steps of a calibration. paper: 35 angles, 6 passes; coarse: 18 angles, 12 passes; fine: 69 angles,
    /// 8 passes; random: as paper, in random order; scan: read while the mirror moves.
    #[arg(long, value_enum)]
    schedule: Option<Schedule>,
    /// The temperature. lab: 27 ± 1 °C; ramp: with time; chamber: cycles; levels: three levels, both ways.
    #[arg(long, value_enum, default_value = "lab")]
    temperature: Climate,
    /// The kind of noise.
    #[arg(long, value_enum, default_value = "white")]
    noise: Family,
    /// An effect to hide, as id:parameter=value,parameter=value; may be given several times.
    #[arg(long = "effect", value_name = "EFFECT")]
    effects: Vec<Injected>,
    /// The file to write, .csv or .csv.gz.
    #[arg(long)]
    out: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Calibration,
    Verification,
}

#[derive(Clone, Copy, ValueEnum)]
enum Schedule {
    Paper,
    Coarse,
    Fine,
    Random,
    Scan,
}

#[derive(Clone, Copy, ValueEnum)]
enum Climate {
    Lab,
    Ramp,
    Chamber,
    Levels,
}

#[derive(Clone, Copy, ValueEnum)]
enum Family {
    White,
    Autocorrelated,
    Heteroscedastic,
    Outliers,
}

/// The program: parses the arguments, runs, and prints the message of what went wrong.
pub fn main() -> ExitCode {
    program(Cli::try_parse(), |cli| run(cli.command, cli.common).map(|()| ExitCode::SUCCESS))
}

/// Runs a command.
///
/// # Errors
/// One message; nothing was written.
pub fn run(command: Command, common: Common) -> Result<()> {
    common.limit();
    match command {
        Command::Record(options) => record(options, common),
        Command::Encode(options) => encode::run(&options, common),
        Command::Excite(options) => moving::excite(options, common),
        Command::Simulate(options) => moving::run(&options, common),
        Command::Effects => {
            let text =
                || effects::catalogue::listing() + "\nIn motion:\n" + &moving_effects::catalogue::listing();
            summarise(common, known_effects, text);
            Ok(())
        }
    }
}

/// The catalogues as JSON.
fn known_effects() -> serde_json::Value {
    let parameter = |name: &str, unit: &str, default: Option<f64>| json!({"name": name, "unit": unit, "default": default});
    let still = effects::catalogue::ALL.iter().map(|effect| {
        let own = effect.parameters.iter().map(|p| parameter(p.name, p.unit, p.default));
        json!({"id": effect.id, "title": effect.title, "parameters": own.collect::<Vec<_>>()})
    });
    let moving = moving_effects::catalogue::ALL.iter().map(|effect| {
        let own = effect.parameters.iter().map(|p| parameter(p.name, p.unit, p.default));
        json!({"id": effect.id, "title": effect.title, "parameters": own.collect::<Vec<_>>()})
    });
    json!({"static": still.collect::<Vec<_>>(), "dynamic": moving.collect::<Vec<_>>()})
}

/// Says how many rows were written.
fn written(rows: usize, out: &Path, common: Common) {
    let out = out.display().to_string();
    summarise(
        common,
        || json!({"rows": rows, "written": out}),
        || format!("{out}: {FIGURE}{rows}{FIGURE:#} rows written"),
    );
}

fn record(options: Record, common: Common) -> Result<()> {
    let mut protocol = match (options.protocol, options.schedule) {
        (Kind::Calibration, None | Some(Schedule::Paper)) => Protocol::calibration(),
        (Kind::Calibration, Some(Schedule::Coarse)) => Protocol::coarse(),
        (Kind::Calibration, Some(Schedule::Fine)) => Protocol::fine(),
        (Kind::Calibration, Some(Schedule::Random)) => Protocol::random(),
        (Kind::Calibration, Some(Schedule::Scan)) => Protocol::scan(),
        (Kind::Verification, None) => Protocol::verification(),
        (Kind::Verification, Some(_)) => {
            return Err(miette!(
                "`--schedule` goes with `--protocol calibration`: a verification has its own"
            ));
        }
    };
    protocol.temperature = match options.temperature {
        Climate::Lab => Temperature::Laboratory,
        Climate::Ramp => Temperature::ramp(),
        Climate::Chamber => Temperature::chamber(),
        Climate::Levels => Temperature::levels(),
    };
    protocol.noise = match options.noise {
        Family::White => Noise::White,
        Family::Autocorrelated => Noise::autocorrelated(),
        Family::Heteroscedastic => Noise::heteroscedastic(),
        Family::Outliers => Noise::outliers(),
    };
    let device = Device::from_seed(options.device_seed.unwrap_or(options.seed));
    let device = device.with_effects(options.effects).into_diagnostic()?;
    protocol.suits(&device).into_diagnostic()?;
    let d = device.geometry.probe_distance_mm;
    let feedback = |x1, x2| crate::calculated_angle_rad(x1, x2, d);
    let log = crate::record(&device, &protocol, options.seed, &feedback);
    crate::write_file(&log, &options.out).into_diagnostic()?;
    written(log.len(), &options.out, common);
    Ok(())
}
