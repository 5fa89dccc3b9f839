//! `effects`: the catalogue of `diagnose`, what can be hidden in a simulated device, and the check of one's own effects.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use diagnosis::effects::{self, Effect, declared, page};
use fitter::Mirror;
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
    let effects = declared::read_file(&args.effects, &Mirror::read(&args.mirror)?.sensor)?;
    let explained: Vec<declared::Explained> = effects.iter().map(Effect::explained).collect();
    let text = || explained.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    summarise(common, || json!(explained), text);
    Ok(())
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
