//! `effects`: the catalogue of `diagnose`, what can be hidden in a simulated device, and the check of one's own effects.

use std::fmt;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use codegen::afford;
use codegen::cost::Core;
use codegen::physics::{Further, FurtherEncoding};
use diagnosis::effects::{self, Effect, declared, page};
use fitter::Mirror;
use serde::Serialize;
use serde_json::json;
use twin::dynamic::effects as moving;
use twin::effects as still;

use crate::terminal::{Common, Result, summarise};

/// Examples for the help.
pub const EXAMPLES: &str = "\
Examples:
  arcsmith effects                                      what `diagnose` can name in calibrations
  arcsmith effects --simulated                          what `record` and `excite` can hide
  arcsmith effects check mine.toml --mirror mirror.toml units and columns of effects of your own";

/// Range of a column that was not given.
const USUAL: (f64, f64) = (1.0, 100.0);

/// Arguments of `effects`.
#[derive(Args)]
pub struct EffectsArgs {
    /// List what can be hidden in a simulated device instead
    #[arg(long)]
    simulated: bool,
    #[command(subcommand)]
    command: Option<EffectsCommand>,
}

#[derive(Subcommand)]
enum EffectsCommand {
    /// Explain a file of declared effects: units, columns, parameters
    Check(CheckArgs),
}

/// Arguments of `effects check`.
#[derive(Args)]
struct CheckArgs {
    /// The effects (TOML)
    effects: PathBuf,
    /// The nominal mirror (mirror.toml)
    #[arg(long)]
    mirror: PathBuf,
    /// Range of a column at run time, for what firmware costs: `coil_a=0..2`; 1 to 100 where it is not given
    #[arg(long = "further", value_name = "COLUMN=FROM..TO")]
    further: Vec<String>,
    /// Seconds between two calls of the firmware
    #[arg(long, default_value_t = 0.001)]
    period_s: f64,
}

/// A declared effect, and what firmware makes of it.
#[derive(Serialize)]
struct Checked {
    #[serde(flatten)]
    explained: declared::Explained,
    firmware: Firmware,
}

/// Whether firmware can compute an effect.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Firmware {
    /// Instructions on a Cortex-M4F and bytes of flash, estimated for these ranges of the columns.
    Computed { instructions: f64, flash_bytes: usize, ranges: Vec<String> },
    /// Why it cannot.
    Refused(String),
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}  firmware   ", self.explained)?;
        match &self.firmware {
            Firmware::Computed { instructions, flash_bytes, ranges } => {
                write!(
                    f,
                    "yes, about {instructions:.0} instructions on a Cortex-M4F and {flash_bytes} bytes of flash"
                )?;
                if ranges.is_empty() { writeln!(f) } else { writeln!(f, ", for {}", ranges.join(", ")) }
            }
            Firmware::Refused(why) => writeln!(f, "no: {why}"),
        }
    }
}

pub fn run(args: &EffectsArgs, common: Common) -> Result<()> {
    match &args.command {
        Some(EffectsCommand::Check(args)) => check(args, common)?,
        None if args.simulated => {
            let text = || still::catalogue::listing() + "\nIn motion:\n" + &moving::catalogue::listing();
            summarise(common, simulated, text);
        }
        None => summarise(common, catalogued, || page::markdown().trim_end().to_string()),
    }
    Ok(())
}

/// What the declared effects are, a paragraph each.
fn check(args: &CheckArgs, common: Common) -> Result<()> {
    let sensor = Mirror::read(&args.mirror)?.sensor;
    let effects = declared::read_file(&args.effects, &sensor)?;
    let given =
        args.further.iter().map(|text| Further::parse(text)).collect::<std::result::Result<Vec<_>, _>>()?;
    let checked: Vec<Checked> = (effects.iter())
        .map(|effect| Checked {
            explained: effect.explained(),
            firmware: firmware(effect, &sensor, &given, args.period_s),
        })
        .collect();
    let text = || checked.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    summarise(common, || json!(checked), text);
    Ok(())
}

/// What firmware makes of an effect whose columns lie in the given ranges, or in usual ones.
fn firmware(
    effect: &Effect,
    sensor: &fitter::error_model::Sensor,
    given: &[Further],
    period_s: f64,
) -> Firmware {
    let expressed = effect.in_the_middle();
    let unknown = ["t_s", "pass", "angle_arcsec", "angle_deg", "s_mm", "measured", "cross_arcsec"];
    let columns = expressed.observables.iter().filter(|name| !unknown.contains(&name.as_str()));
    let further: Vec<Further> = columns
        .map(|name| {
            let (from, to) = if name == "direction" { (-1.0, 1.0) } else { USUAL };
            let usual = Further { observable: name.clone(), from, to, encoding: FurtherEncoding::Q31 };
            given.iter().find(|other| other.observable == *name).cloned().unwrap_or(usual)
        })
        .collect();
    match afford::expression(&expressed, sensor, (&further, period_s), Core::CortexM4f) {
        Ok(cost) => Firmware::Computed {
            instructions: cost.instructions,
            flash_bytes: cost.flash_bytes,
            ranges: further.iter().map(|f| format!("{}={}..{}", f.observable, f.from, f.to)).collect(),
        },
        Err(why) => Firmware::Refused(why),
    }
}

/// The catalogue of `diagnose` as JSON.
fn catalogued() -> serde_json::Value {
    let entry = |effect: &Effect| {
        json!({
            "id": effect.id, "title": effect.title, "formula": effect.formula, "size": effect.size,
            "confused_with": effect.confused_with, "source": effect.source,
            "runtime_correctable": !effect.of_one_time,
        })
    };
    effects::listed().iter().map(entry).collect()
}

/// The catalogues of the simulation as JSON.
fn simulated() -> serde_json::Value {
    let parameter = |name: &str, unit: &str, default: Option<f64>| json!({"name": name, "unit": unit, "default": default});
    let still = self::still::catalogue::ALL.iter().map(|effect| {
        let own = effect.parameters.iter().map(|p| parameter(p.name, p.unit, p.default));
        json!({"id": effect.id, "title": effect.title, "parameters": own.collect::<Vec<_>>()})
    });
    let moving = self::moving::catalogue::ALL.iter().map(|effect| {
        let own = effect.parameters.iter().map(|p| parameter(p.name, p.unit, p.default));
        json!({"id": effect.id, "title": effect.title, "parameters": own.collect::<Vec<_>>()})
    });
    json!({"static": still.collect::<Vec<_>>(), "dynamic": moving.collect::<Vec<_>>()})
}
