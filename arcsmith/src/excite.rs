//! `excite`: a simulated mechanism in motion.

use std::path::PathBuf;

use clap::Args;
use fitter::plant::{Numbers, PlantEffect};
use twin::dynamic::{Bench, Excitation, bench};
use twin::log::write_series;
use twin::{Injected, Noise};

use crate::record::{among, written};
use crate::terminal::{Common, Result};

/// Arguments of `excite`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith excite --seed 7 --out motion.csv
  arcsmith excite --seed 7 --excitation sweep --runs 4 --effect cubic_stiffness:coefficient=3e-7 --out motion.csv.gz")]
pub struct Excite {
    /// Seed of the recording.
    #[arg(long)]
    seed: u64,
    /// Seed of the mechanism, where it is not that of the recording.
    #[arg(long)]
    device_seed: Option<u64>,
    /// What it is driven with; all up to 120 Hz, steps are held for 50 ms.
    #[arg(long, value_parser = among(&EXCITATIONS), default_value = "multisine")]
    excitation: Excitation,
    /// Samples of a run (of a period, where it is periodic), at 2 kHz.
    #[arg(long, default_value_t = 16_384, value_parser = clap::value_parser!(u32).range(16..=1 << 22))]
    samples: u32,
    /// Record so many periods in the steady state, not from rest.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=64))]
    periods: Option<u32>,
    /// Independent runs.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    runs: u32,
    /// The kind of noise of the position; autocorrelated: over 2 ms.
    #[arg(long, value_parser = among(&NOISES), default_value = "white")]
    noise: Noise,
    /// An effect to hide, as id:parameter=value,parameter=value; may be given several times.
    #[arg(long = "effect", value_name = "EFFECT")]
    effects: Vec<Injected>,
    /// The file to write, .csv or .csv.gz.
    #[arg(long)]
    out: PathBuf,
}

const HIGHEST_HZ: f64 = 120.0;
const EXCITATIONS: [(&str, Excitation); 4] = [
    ("multisine", Excitation::Multisine { highest_hz: HIGHEST_HZ, odd: false }),
    ("odd-multisine", Excitation::Multisine { highest_hz: HIGHEST_HZ, odd: true }),
    ("sweep", Excitation::Sweep { lowest_hz: 1.0, highest_hz: HIGHEST_HZ }),
    ("steps", Excitation::Steps { hold_s: 0.05 }),
];
const NOISES: [(&str, Noise); 2] =
    [("white", Noise::White), ("autocorrelated", Noise::Autocorrelated { correlation_time_s: 2e-3 })];

pub fn run(options: Excite, common: Common) -> Result<()> {
    let bench = Bench {
        excitation: options.excitation,
        samples: options.samples as usize,
        periods: options.periods,
        runs: options.runs,
        noise: options.noise,
        ..Bench::from_seed(options.device_seed.unwrap_or(options.seed))
    };
    let effects = options.effects.into_iter().map(|effect| PlantEffect {
        id: effect.id,
        parameters: effect.parameters.into_iter().map(|(name, value)| (name, Numbers::One(value))).collect(),
    });
    let bench = bench.with_effects(effects.collect())?;
    let series = bench.record(options.seed)?;
    write_series(&series, Some(bench::DECIMALS), &options.out)?;
    written(series.t_s.len(), &options.out, common);
    Ok(())
}
