//! `twin record`: simulates a recording and writes it.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use miette::IntoDiagnostic;
use twin::{Device, Protocol};

/// Simulates the calibration of a scanning mirror.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Steps a device through a protocol in closed loop on the calculated angle and writes the log.
    Record {
        /// calibration: ±1.7° in steps of 0.1°; verification: ±1.4° in steps of 0.2°; six passes each.
        #[arg(long, value_enum)]
        protocol: Kind,
        /// Seed of the recording.
        #[arg(long)]
        seed: u64,
        /// Seed of the device, where it is not that of the recording: the same device recorded again.
        #[arg(long)]
        device_seed: Option<u64>,
        /// The file to write, .csv or .csv.gz.
        #[arg(long)]
        out: PathBuf,
    },
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Calibration,
    Verification,
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
        Command::Record { protocol, seed, device_seed, out } => {
            let protocol = match protocol {
                Kind::Calibration => Protocol::calibration(),
                Kind::Verification => Protocol::verification(),
            };
            let device = Device::from_seed(device_seed.unwrap_or(seed));
            let d = device.geometry.probe_distance_mm;
            let feedback = |x1, x2| twin::calculated_angle_rad(x1, x2, d);
            let log = twin::record(&device, &protocol, seed, &feedback);
            twin::write_file(&log, &out).into_diagnostic()
        }
    }
}
