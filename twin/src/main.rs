//! `twin`: simulates recordings and writes them.

mod encode;
mod moving;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};
use miette::{IntoDiagnostic, miette};
use twin::dynamic::effects as moving_effects;
use twin::{Device, Injected, Noise, Protocol, Temperature, effects};

/// Simulates a scanning mirror: its calibration, and its motion.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Steps a device through a protocol in closed loop on the calculated angle and writes the log.
    Record(Record),
    /// Turns a magnetic encoder against a reference and writes what both read.
    Encode(encode::Encode),
    /// Excites a mirror in motion and writes drive and position.
    Excite(moving::Excite),
    /// Runs a plant, with all that was found in it, on the drive of a recording and writes the position.
    Simulate(moving::Simulate),
    /// Lists the effects that can be hidden in a device, with their parameters.
    Effects,
}

#[derive(Args)]
struct Record {
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

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            eprintln!("{report:?}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Arguments) -> miette::Result<()> {
    match arguments.command {
        Command::Record(options) => record(options),
        Command::Encode(options) => encode::run(&options),
        Command::Excite(options) => moving::excite(options),
        Command::Simulate(options) => moving::run(&options),
        Command::Effects => {
            // A reader that has seen enough closes the pipe, which is no error.
            let text =
                effects::catalogue::listing() + "\nIn motion:\n" + &moving_effects::catalogue::listing();
            let _ = std::io::stdout().write_all(text.as_bytes());
            Ok(())
        }
    }
}

fn record(options: Record) -> miette::Result<()> {
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
    let feedback = |x1, x2| twin::calculated_angle_rad(x1, x2, d);
    let log = twin::record(&device, &protocol, options.seed, &feedback);
    twin::write_file(&log, &options.out).into_diagnostic()
}
