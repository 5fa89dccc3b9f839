//! The command line of `diagnose` for dynamic recordings.

use std::io::Write;
use std::path::Path;

use fitter::cli::Common;
use fitter::output::FileSet;
use fitter::plant::{Kind, PlantFile};
use fitter::text_safety;
use miette::{IntoDiagnostic, Result, miette};
use rayon::prelude::*;

use crate::cli::{Arguments, progress, stems, tell, threads};
use crate::dynamic::diagnose::Predicted;
use crate::dynamic::linear::{self, diagnose_linear};
use crate::dynamic::model::Term;
use crate::dynamic::recording::Reading;
use crate::dynamic::{self, DynamicOutcome, DynamicRecording, Options, OwnSimulation};

/// Diagnoses dynamic recordings against the plant file.
pub(crate) fn run(cli: &Arguments, plant: &Path, common: Common) -> Result<()> {
    let file = PlantFile::read(plant).into_diagnostic()?;
    let given = given(plant, &file)?;
    let stems = stems(&cli.recordings)?;
    known(&cli.without)?;
    if cli.simulated.is_some() && cli.recordings.len() > 1 {
        return Err(miette!(
            "--simulated: found {} recordings, expected one; a simulation belongs to the rows of one recording",
            cli.recordings.len()
        ));
    }
    let reading = Reading {
        position_unit: &file.plant.position_unit,
        drive_unit: &file.plant.drive_unit,
        command: file.plant.feedback.as_deref(),
        mappings: &cli.map.map,
    };
    let read = |path: &Path| DynamicRecording::read(path, &reading).into_diagnostic();
    let recordings: Vec<DynamicRecording> =
        cli.recordings.par_iter().map(|path| read(path)).collect::<Result<_>>()?;
    let held_out = cli.held_out.as_deref().map(read).transpose()?;
    let simulated = cli.simulated.as_deref().map(|path| own(path, &recordings[0])).transpose()?;
    let options = Options { skip: cli.without.clone(), given };
    let bar = progress(recordings.len(), common);
    let pool = threads(cli.jobs)?;
    let outcomes: Vec<Result<DynamicOutcome>> = pool.install(|| {
        recordings
            .par_iter()
            .map(|recording| {
                let (own, other) = (simulated.as_ref(), held_out.as_ref());
                let outcome = match file.plant.kind {
                    Kind::SecondOrder => dynamic::diagnose(recording, &file.plant, own, other, &options),
                    Kind::Linear => diagnose_linear(recording, &file, own, other, &options.skip),
                };
                bar.inc(1);
                outcome.into_diagnostic()
            })
            .collect()
    });
    bar.finish_and_clear();
    let outcomes: Vec<DynamicOutcome> = outcomes.into_iter().collect::<Result<_>>()?;
    let mut set = FileSet::new();
    set.folder(&cli.out).into_diagnostic()?;
    for ((stem, recording), outcome) in stems.iter().zip(&recordings).zip(&outcomes) {
        let at = |end: &str| cli.out.join(format!("{stem}.{end}"));
        if !cli.no_report {
            set.put(&at("html"), dynamic::report::page(recording, outcome)).into_diagnostic()?;
        }
        let rows = table(outcome.other.as_ref().unwrap_or(&outcome.own));
        set.put(&at("simulated.csv"), rows).into_diagnostic()?;
        set.put(&at("plant.toml"), outcome.plant.to_toml()).into_diagnostic()?;
        // The answer last: it names the others.
        let text = serde_json::to_string_pretty(&outcome.diagnosis).into_diagnostic()? + "\n";
        set.put(&at("json"), text).into_diagnostic()?;
    }
    set.commit().into_diagnostic()?;
    let outcomes: Vec<_> = outcomes.iter().map(|outcome| &outcome.diagnosis).collect();
    tell(&outcomes, &cli.out, common);
    Ok(())
}

/// The effects that the plant file gives; refuses ids that no effect has.
fn given(path: &Path, file: &PlantFile) -> Result<Vec<Term>> {
    let name = path.display().to_string();
    match file.plant.kind {
        Kind::SecondOrder => {
            let all: Vec<&str> = dynamic::effects::CATALOGUE.iter().map(|e| e.id()).collect();
            file.check_effects(&name, &all).into_diagnostic()?;
            let names = |id: &str| dynamic::effects::effect(id).map_or(Vec::new(), |e| e.names());
            file.check_parameters(&name, names).into_diagnostic()?;
            dynamic::plant::given(&name, file).into_diagnostic()
        }
        Kind::Linear => {
            file.check_effects(&name, &[linear::file::ID, linear::offset::ID]).into_diagnostic()?;
            file.check_parameters(&name, linear::file::names).into_diagnostic()?;
            Ok(Vec::new())
        }
    }
}

/// Refuses ids that no effect has.
fn known(ids: &[String]) -> Result<()> {
    let mut all: Vec<&str> = dynamic::effects::CATALOGUE.iter().map(|e| e.id()).collect();
    all.push(linear::file::ID);
    match ids.iter().find(|id| !all.contains(&id.as_str())) {
        None => Ok(()),
        Some(id) => Err(miette!("--without: found `{id}`, expected one of {}", all.join(", "))),
    }
}

/// The user's own simulation: the same rows, with `position` predicted.
fn own(path: &Path, recording: &DynamicRecording) -> Result<OwnSimulation> {
    let simulation = crate::simulated::read(path).into_diagnostic()?;
    let positions = simulation.positions_for(&recording.t_s).into_diagnostic()?;
    let file = text_safety::file_name(path);
    Ok(OwnSimulation { file, positions })
}

/// `t_s,before,after`, numbered where there are several positions.
fn table(predicted: &Predicted) -> String {
    let mut text = Vec::new();
    let several = predicted.before.len() > 1;
    let name = |what: &str, k: usize| if several { format!("{what}_{}", k + 1) } else { what.to_string() };
    let columns = predicted.before.len();
    let names = (0..columns).map(|k| name("before", k)).chain((0..columns).map(|k| name("after", k)));
    let header: Vec<String> = std::iter::once("t_s".to_string()).chain(names).collect();
    // Writing to memory does not fail.
    let _ = writeln!(text, "{}", header.join(","));
    for (k, t) in predicted.t_s.iter().enumerate() {
        let _ = write!(text, "{t}");
        for column in predicted.before.iter().chain(&predicted.after) {
            let _ = write!(text, ",{}", column[k]);
        }
        let _ = writeln!(text);
    }
    String::from_utf8(text).unwrap_or_default()
}
