//! `init`: a commented project file, or the nominal mirror alone.

use std::path::PathBuf;

use clap::Args;
use codegen::cli::recording;
use codegen::refused;
use fitter::{mirror, output};
use serde_json::json;

use crate::project;
use crate::project::init::{self, Kind};
use crate::terminal::{Common, Result, line, summarise};

/// Arguments of `init`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith init --from calibration.csv           a project of this recording: arcsmith.toml
  arcsmith init                                  a project of two eddy-current probes, to fill in
  arcsmith init --kind encoder                   a project of an encoder that turns round and round
  arcsmith init --out mirror.toml                the nominal mirror alone, for --mirror")]
pub struct InitArgs {
    /// The recording: its columns are recognised, units that it does not say are guessed and marked
    #[arg(long, value_name = "RECORDING", value_parser = recording())]
    from: Option<PathBuf>,
    /// What the recordings are of [default: what --from shows, else mirror]
    #[arg(long, value_enum)]
    kind: Option<Kind>,
    /// Where to write it; a file of another name than arcsmith.toml holds the nominal mirror alone
    #[arg(long, default_value = project::FILE)]
    out: PathBuf,
    /// Write over a file that is there
    #[arg(long)]
    force: bool,
}

pub fn run(args: &InitArgs, common: Common) -> Result<()> {
    let out = args.out.display().to_string();
    if args.out.is_file() && !args.force {
        return Err(refused!("is there already")
            .at(&out)
            .mend("give another --out, or --force to write over it"));
    }
    if args.out.file_name().is_some_and(|name| name == project::FILE) {
        return of_project(args, &out, common);
    }
    if args.from.is_some() {
        return Err(refused!("--from belongs to a project")
            .found(format!("--out {out}"))
            .mend("leave --out away"));
    }
    let text = match args.kind {
        None | Some(Kind::Mirror) => mirror::PAIR_FILE,
        Some(Kind::Direct) => mirror::DIRECT_FILE,
        Some(Kind::Encoder) => mirror::ENCODER_FILE,
        Some(Kind::Motion) => {
            return Err(refused!("--kind motion belongs to a project").mend("leave --out away"));
        }
    };
    output::write_whole(&args.out, |file| file.write_all(text.as_bytes()))?;
    summarise(
        common,
        || json!({"written": out}),
        || format!("{out}: written; state your values in it, then fit a recording with --mirror {out}"),
    );
    Ok(())
}

/// Writes a project file.
fn of_project(args: &InitArgs, out: &str, common: Common) -> Result<()> {
    let new = match &args.from {
        Some(path) => init::of_recording(path, args.kind)?,
        None => init::without_recording(args.kind.unwrap_or(Kind::Mirror)),
    };
    output::write_whole(&args.out, |file| file.write_all(new.text.as_bytes()))?;
    let seen = new.seen.as_ref();
    summarise(
        common,
        || {
            let mut value = json!({"written": out, "next": "arcsmith run"});
            if let Some(seen) = seen {
                value["recording"] = json!(seen.file);
                value["rows"] = json!(seen.rows);
                value["as_they_are"] = json!(seen.as_they_are);
                value["mapped"] = json!(seen.mapped);
                value["guessed"] = json!(seen.guessed);
                value["started"] = json!(seen.started);
            }
            value
        },
        || said(out, seen),
    );
    Ok(())
}

/// What was written and seen, for people.
fn said(out: &str, seen: Option<&init::Seen>) -> String {
    let Some(seen) = seen else {
        return format!("{out}: written; state your recording and your values in it, then: arcsmith run");
    };
    let mut text = format!("{out}: written from the {} rows of {}\n", seen.rows, seen.file);
    if !seen.as_they_are.is_empty() {
        text += &line("columns", &seen.as_they_are.join(", "));
    }
    if !seen.mapped.is_empty() {
        text += &line("read as", &seen.mapped.join(", "));
    }
    if let Some(from) = &seen.started {
        text += &line("time", &format!("timestamps, taken as seconds since the first row, {from}"));
    }
    if !seen.guessed.is_empty() {
        text += &line("guessed", &format!("{}: look at them in {out}", seen.guessed.join(", ")));
    }
    text + &line("next", &format!("state your design values in {out}, then: arcsmith run"))
}
