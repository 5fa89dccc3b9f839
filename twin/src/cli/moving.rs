//! `twin excite` and `twin simulate`: moving mechanisms on the command line.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fitter::output::not_the_input;
use fitter::plant::{Numbers, PlantEffect, PlantFile};
use miette::IntoDiagnostic;

use super::{Common, written};
use crate::dynamic::{Begin, Bench, Excitation, Series, bench, simulate};
use crate::log::write_series;
use crate::{Injected, Noise};

/// Arguments of `twin excite`.
#[derive(Args)]
pub struct Excite {
    /// Seed of the recording.
    #[arg(long)]
    seed: u64,
    /// Seed of the mechanism, where it is not that of the recording.
    #[arg(long)]
    device_seed: Option<u64>,
    /// What it is driven with; all up to 120 Hz, steps are held for 50 ms.
    #[arg(long, value_enum, default_value = "multisine")]
    excitation: Kind,
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
    #[arg(long, value_enum, default_value = "white")]
    noise: Colour,
    /// An effect to hide, as id:parameter=value,parameter=value; may be given several times.
    #[arg(long = "effect", value_name = "EFFECT")]
    effects: Vec<Injected>,
    /// The file to write, .csv or .csv.gz.
    #[arg(long)]
    out: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Multisine,
    OddMultisine,
    Sweep,
    Steps,
}

#[derive(Clone, Copy, ValueEnum)]
enum Colour {
    White,
    Autocorrelated,
}

/// Arguments of `twin simulate`.
#[derive(Args)]
pub struct Simulate {
    /// The plant with its numbers, as `diagnose` writes it.
    #[arg(long)]
    plant: PathBuf,
    /// A recording with the columns t_s and drive (drive_1, drive_2, …), .csv or .csv.gz.
    #[arg(long)]
    drive: PathBuf,
    /// How each run begins. recorded: as the first 50 rows of the recorded position (or one period of the mechanism's
    /// own vibration) say, if there is one; rest:
    /// at rest. A recording with a column `period` is simulated in its steady state.
    #[arg(long, value_enum)]
    begin: Option<Beginning>,
    /// The file to write, .csv or .csv.gz: t_s and position.
    #[arg(long)]
    out: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum Beginning {
    Recorded,
    Rest,
}

pub(super) fn excite(options: Excite, common: Common) -> miette::Result<()> {
    let highest_hz = 120.0;
    let bench = Bench {
        excitation: match options.excitation {
            Kind::Multisine => Excitation::Multisine { highest_hz, odd: false },
            Kind::OddMultisine => Excitation::Multisine { highest_hz, odd: true },
            Kind::Sweep => Excitation::Sweep { lowest_hz: 1.0, highest_hz },
            Kind::Steps => Excitation::Steps { hold_s: 0.05 },
        },
        samples: options.samples as usize,
        periods: options.periods,
        runs: options.runs,
        noise: match options.noise {
            Colour::White => Noise::White,
            Colour::Autocorrelated => Noise::Autocorrelated { correlation_time_s: 2e-3 },
        },
        ..Bench::from_seed(options.device_seed.unwrap_or(options.seed))
    };
    let effects = options.effects.into_iter().map(|effect| PlantEffect {
        id: effect.id,
        parameters: effect.parameters.into_iter().map(|(name, value)| (name, Numbers::One(value))).collect(),
    });
    let bench = bench.with_effects(effects.collect()).into_diagnostic()?;
    let series = bench.record(options.seed).into_diagnostic()?;
    write_series(&series, Some(bench::DECIMALS), &options.out).into_diagnostic()?;
    written(series.t_s.len(), &options.out, common);
    Ok(())
}

pub(super) fn run(options: &Simulate, common: Common) -> miette::Result<()> {
    let plant = PlantFile::read(&options.plant).into_diagnostic()?;
    let recording = Series::read(&options.drive).into_diagnostic()?;
    not_the_input(&options.out, &[&options.drive, &options.plant]).into_diagnostic()?;
    let begin = match options.begin {
        Some(Beginning::Recorded) => Begin::Recorded,
        Some(Beginning::Rest) => Begin::Rest,
        None if recording.positions.len() == 1 && plant.state_space.is_none() => Begin::Recorded,
        None => Begin::Rest,
    };
    let simulated =
        simulate(&options.plant.display().to_string(), &plant, &recording, begin).into_diagnostic()?;
    write_series(&simulated, None, &options.out).into_diagnostic()?;
    written(simulated.t_s.len(), &options.out, common);
    Ok(())
}
