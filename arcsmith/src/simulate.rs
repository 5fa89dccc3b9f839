//! `simulate`: a plant on the drive of a recording.

use std::path::PathBuf;

use clap::Args;
use fitter::output::not_the_input;
use fitter::plant::PlantFile;
use fitter::recording::Note;
use fitter::text_safety;
use twin::dynamic::{Begin, Series, simulate};
use twin::log::write_series;

use crate::record::{among, written};
use crate::terminal::{Common, Result, warn};
use codegen::cli::recording;

/// Arguments of `simulate`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  arcsmith simulate --plant motion.plant.toml --drive motion.csv --out simulated.csv
  arcsmith simulate --plant plant.toml --drive motion.csv --begin rest --out simulated.csv")]
pub struct Simulate {
    /// The plant with its numbers, as `diagnose` writes it.
    #[arg(long)]
    plant: PathBuf,
    /// A recording with the columns t_s and drive (drive_1, drive_2, …), .csv or .csv.gz; `-`: standard input.
    #[arg(long, value_parser = recording())]
    drive: PathBuf,
    /// How each run begins. recorded: as the first 50 rows of the recorded position (or one period of the mechanism's
    /// own vibration) say, if there is one; rest:
    /// at rest. A recording with a column `period` is simulated in its steady state.
    #[arg(long, value_parser = among(&BEGINNINGS))]
    begin: Option<Begin>,
    /// The file to write, .csv or .csv.gz: t_s and position.
    #[arg(long)]
    out: PathBuf,
}

const BEGINNINGS: [(&str, Begin); 2] = [("recorded", Begin::Recorded), ("rest", Begin::Rest)];

pub fn run(options: &Simulate, common: Common) -> Result<()> {
    let plant = PlantFile::read(&options.plant)?;
    let undriven = plant.equations.as_ref().is_some_and(|equations| equations.inputs.0.is_empty());
    let recording =
        if undriven { Series::read_undriven(&options.drive)? } else { Series::read(&options.drive)? };
    if let Some(first) = recording.started.clone() {
        warn(&format!("{}: {}", text_safety::file_name(&options.drive), Note::since(first)), common);
    }
    not_the_input(&options.out, &[&options.drive, &options.plant])?;
    let known = recording.positions.len() == 1 && plant.state_space.is_none();
    let begin = options.begin.unwrap_or(if known { Begin::Recorded } else { Begin::Rest });
    let simulated = simulate(&options.plant.display().to_string(), &plant, &recording, begin)?;
    write_series(&simulated, None, &options.out)?;
    written(simulated.t_s.len(), &options.out, common);
    Ok(())
}
