//! `init`: a commented mirror.toml to fill in.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use codegen::refused;
use fitter::{mirror, output};
use serde_json::json;

use crate::terminal::{Common, Result, summarise};

/// Arguments of `init`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith init                                  two eddy-current probes and an autocollimator
  arcsmith init --kind encoder --out motor.toml  an encoder that turns round and round")]
pub struct InitArgs {
    /// What the file is to describe
    #[arg(long, value_enum, default_value_t = Kind::Mirror)]
    kind: Kind,
    /// Where to write it
    #[arg(long, default_value = "mirror.toml")]
    out: PathBuf,
    /// Write over a file that is there
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Two eddy-current probes on either side of the axis
    Mirror,
    /// A sensor that reports the angle or position itself
    Direct,
    /// A direct sensor that turns round and round
    Encoder,
}

pub fn run(args: &InitArgs, common: Common) -> Result<()> {
    let out = args.out.display().to_string();
    if args.out.is_file() && !args.force {
        return Err(refused!("is there already")
            .at(&out)
            .mend("give another --out, or --force to write over it"));
    }
    let text = match args.kind {
        Kind::Mirror => mirror::PAIR_FILE,
        Kind::Direct => mirror::DIRECT_FILE,
        Kind::Encoder => mirror::ENCODER_FILE,
    };
    output::write_whole(&args.out, |file| file.write_all(text.as_bytes()))?;
    summarise(
        common,
        || json!({"written": out}),
        || format!("{out}: written; state your values in it, then fit a recording with --mirror {out}"),
    );
    Ok(())
}
