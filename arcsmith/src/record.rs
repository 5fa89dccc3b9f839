//! `record`: a simulated calibration.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
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
    #[arg(long, value_parser = among(&SCHEDULES))]
    schedule: Option<fn() -> Protocol>,
    /// The temperature. lab: 27 ± 1 °C; ramp: with time; chamber: cycles; levels: three levels, both ways.
    #[arg(long, value_parser = among(&TEMPERATURES), default_value = "lab")]
    temperature: fn() -> Temperature,
    /// The kind of noise.
    #[arg(long, value_parser = among(&NOISES), default_value = "white")]
    noise: fn() -> Noise,
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

/// What a value of an option is called, and what makes it.
type Named<T> = (&'static str, fn() -> T);

const SCHEDULES: [Named<Protocol>; 5] = [
    ("paper", Protocol::calibration),
    ("coarse", Protocol::coarse),
    ("fine", Protocol::fine),
    ("random", Protocol::random),
    ("scan", Protocol::scan),
];
const TEMPERATURES: [Named<Temperature>; 4] = [
    ("lab", || Temperature::Laboratory),
    ("ramp", Temperature::ramp),
    ("chamber", Temperature::chamber),
    ("levels", Temperature::levels),
];
/// Kinds of noise; an encoder has the first two.
pub const NOISES: [Named<Noise>; 4] = [
    ("white", || Noise::White),
    ("autocorrelated", Noise::autocorrelated),
    ("heteroscedastic", Noise::heteroscedastic),
    ("outliers", Noise::outliers),
];

/// An option that takes one of these names, and what stands beside it.
pub fn among<T: Copy + Send + Sync>(named: &'static [(&str, T)]) -> impl TypedValueParser<Value = T> {
    let value = |name: String| named.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
    PossibleValuesParser::new(named.iter().map(|(name, _)| *name))
        .try_map(move |name| value(name).ok_or("it is none of them"))
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
        (Kind::Calibration, schedule) => schedule.unwrap_or(Protocol::calibration)(),
        (Kind::Verification, None) => Protocol::verification(),
        (Kind::Verification, Some(_)) => {
            return Err(refused!(
                "`--schedule` goes with `--protocol calibration`: a verification has its own"
            ));
        }
    };
    protocol.temperature = (options.temperature)();
    protocol.noise = (options.noise)();
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
