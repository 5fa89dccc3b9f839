//! `encode`: a simulated sensor that reports the angle itself.

use std::path::PathBuf;

use clap::Args;
use codegen::refused;
use twin::Noise;
use twin::encoder::{Encoder, Turning, Unit, record, write_file};

use crate::record::{NOISES, among, written};
use crate::terminal::{Common, Result};

/// Arguments of `encode`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith encode --seed 7 --out encoder.csv
  arcsmith encode --seed 7 --unit counts --turns 3 --out counts.csv.gz")]
pub struct Encode {
    /// Seed of the recording.
    #[arg(long)]
    seed: u64,
    /// Seed of the encoder, where it is not that of the recording: the same encoder recorded again.
    #[arg(long)]
    device_seed: Option<u64>,
    /// The unit of both columns; counts are of 14 bits.
    #[arg(long, value_parser = among(&UNITS), default_value = "deg")]
    unit: Unit,
    /// Turns of one pass.
    #[arg(long, default_value_t = 1.2)]
    turns: f64,
    /// Passes, forward and backward in turn.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=1000))]
    passes: u32,
    /// Readings of a turn.
    #[arg(long, default_value_t = 120, value_parser = clap::value_parser!(u32).range(8..=100_000))]
    readings: u32,
    /// Speed in degrees per second; every second pair of passes runs twice as fast.
    #[arg(long, default_value_t = 30.0)]
    speed: f64,
    /// Let the readings go on beyond a revolution.
    #[arg(long)]
    unwrapped: bool,
    /// The kind of noise.
    #[arg(long, value_parser = among(&NOISES[..2]), default_value = "white")]
    noise: fn() -> Noise,
    /// The file to write, .csv or .csv.gz.
    #[arg(long)]
    out: PathBuf,
}

const UNITS: [(&str, Unit); 2] = [("deg", Unit::Degrees), ("counts", Unit::Counts)];

pub fn run(options: &Encode, common: Common) -> Result<()> {
    for (name, value, most) in [("--turns", options.turns, 1000.0), ("--speed", options.speed, 36_000.0)] {
        if !(value > 0.0 && value <= most) {
            let expected = format!("a number above 0 and up to {most}");
            return Err(refused!("{name} is {value}").expected(expected).mend("correct it"));
        }
    }
    let encoder = Encoder::from_seed(options.device_seed.unwrap_or(options.seed));
    let turning = Turning {
        turns: options.turns,
        passes: options.passes,
        readings_per_turn: options.readings,
        speed_deg_per_s: options.speed,
        wraps: !options.unwrapped,
        unit: options.unit,
        noise: (options.noise)(),
        ..Turning::default()
    };
    let log = record(&encoder, &turning, options.seed);
    write_file(&log, &options.out)?;
    written(log.len(), &options.out, common);
    Ok(())
}
