//! `record`: a simulated calibration.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use codegen::refused;
use serde_json::json;
use twin::{Device, Injected, Noise, Protocol, Temperature};

use crate::terminal::{Common, FIGURE, Result, summarise};

/// Arguments of `record`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith record --protocol calibration --seed 7 --out calibration.csv
  arcsmith record --protocol verification --device-seed 7 --seed 8 --out verification.csv
  arcsmith record --protocol calibration --seed 7 --temperature levels \\
      --effect thermal_zero_drift:coefficient_arcsec_per_k=0.2 --out warm.csv")]
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

/// Says how many rows were written.
pub fn written(rows: usize, out: &Path, common: Common) {
    let out = out.display().to_string();
    summarise(
        common,
        || json!({"rows": rows, "written": out}),
        || format!("{out}: {FIGURE}{rows}{FIGURE:#} rows written"),
    );
}

pub fn run(options: Record, common: Common) -> Result<()> {
    let mut protocol = match (options.protocol, options.schedule) {
        (Kind::Calibration, None | Some(Schedule::Paper)) => Protocol::calibration(),
        (Kind::Calibration, Some(Schedule::Coarse)) => Protocol::coarse(),
        (Kind::Calibration, Some(Schedule::Fine)) => Protocol::fine(),
        (Kind::Calibration, Some(Schedule::Random)) => Protocol::random(),
        (Kind::Calibration, Some(Schedule::Scan)) => Protocol::scan(),
        (Kind::Verification, None) => Protocol::verification(),
        (Kind::Verification, Some(_)) => {
            return Err(refused!(
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
    let device = device.with_effects(options.effects)?;
    protocol.suits(&device)?;
    let d = device.geometry.probe_distance_mm;
    let feedback = |x1, x2| twin::calculated_angle_rad(x1, x2, d);
    let log = twin::record(&device, &protocol, options.seed, &feedback);
    twin::write_file(&log, &options.out)?;
    written(log.len(), &options.out, common);
    Ok(())
}
