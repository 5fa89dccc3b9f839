//! `diagnose` of dynamic recordings.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use diagnosis::dynamic::diagnose::Predicted;
use diagnosis::dynamic::linear;
use diagnosis::dynamic::model::Term;

use codegen::refused;
use diagnosis::dynamic::equations::MotionEffect;
use diagnosis::dynamic::{self, Case, DynamicRecording, Options, OwnSimulation, Reading};
use diagnosis::simulated;
use fitter::output::FileSet;
use fitter::plant::{Kind, PlantFile};
use fitter::recording::Mapping;
use fitter::text_safety;
use pages::Beside;
use rayon::prelude::*;

use crate::next;

use super::{Arguments, all, known, one_simulation, stems, tell, tell_times};
use crate::terminal::{Common, Result};

/// Diagnoses dynamic recordings against the plant file.
pub fn run(cli: &Arguments, plant: &Path, common: Common) -> Result<()> {
    let file = PlantFile::read(plant)?;
    let name = text_safety::path(plant);
    let options = options(plant, &file, cli.device.effects.as_deref(), &cli.device.without)?;
    let stems = stems(&cli.recordings)?;
    one_simulation(cli)?;
    let reading = reading(&file, &cli.device.map.map);
    let read = |path: &Path| -> Result<_> { Ok(DynamicRecording::read(path, &reading)?) };
    let recordings: Vec<DynamicRecording> =
        cli.recordings.par_iter().map(|path| read(path)).collect::<Result<_>>()?;
    recordings.iter().for_each(|recording| tell_times(&recording.file, &recording.notes, common));
    let held_out = cli.held_out.as_deref().map(read).transpose()?;
    let simulated = cli.simulated.as_deref().map(|path| own(path, &recordings[0])).transpose()?;
    let (simulated, held_out) = (simulated.as_ref(), held_out.as_ref());
    let outcomes = all(cli, common, &recordings, |recording| {
        Ok(dynamic::diagnose(&Case {
            recording,
            plant: &file,
            plant_file: &name,
            simulated,
            held_out,
            options: &options,
        })?)
    })?;
    let mut set = FileSet::new();
    set.folder(&cli.out)?;
    for (((stem, path), recording), outcome) in
        stems.iter().zip(&cli.recordings).zip(&recordings).zip(&outcomes)
    {
        let at = |end: &str| cli.out.join(format!("{stem}.{end}"));
        if !cli.no_report {
            let written = ["html", "json", "plant.toml", "simulated.csv"].map(at);
            let beside = Beside {
                next: next::after_motion(&at("plant.toml"), path),
                written: written.iter().map(|path| text_safety::path(path)).collect(),
            };
            set.put(&at("html"), diagnosis::report::of_motion(recording, outcome, &beside))?;
        }
        let rows = table(outcome.other.as_ref().unwrap_or(&outcome.own));
        set.put(&at("simulated.csv"), rows)?;
        set.put(&at("plant.toml"), outcome.plant.to_toml())?;
        // The answer last: it names the others.
        let text = serde_json::to_string_pretty(&outcome.diagnosis)? + "\n";
        set.put(&at("json"), text)?;
    }
    set.commit()?;
    tell(outcomes.iter().map(|outcome| &outcome.diagnosis), &cli.out, common);
    Ok(())
}

/// How a recording of a plant is read.
pub fn reading<'a>(file: &'a PlantFile, mappings: &'a [Mapping]) -> Reading<'a> {
    Reading {
        position_unit: &file.plant.position_unit,
        drive_unit: &file.plant.drive_unit,
        command: file.plant.feedback.as_deref(),
        mappings,
        in_equations: file.plant.kind == Kind::Equations,
    }
}

/// What is asked for: the effects that the plant gives, those that a file declares, and those that are left out; refuses
/// `without` to name what is in no catalogue.
pub fn options(
    plant: &Path,
    file: &PlantFile,
    effects: Option<&Path>,
    without: &[String],
) -> Result<Options> {
    let given = given(plant, file)?;
    let own = own_effects(effects, &text_safety::path(plant), file)?;
    let entries = dynamic::equations::entries();
    let mut ids: Vec<&str> = vec![linear::file::ID];
    ids.extend(dynamic::effects::under_feedback().map(|e| e.id));
    ids.extend(
        entries.iter().filter(|_| file.equations.is_some() || !own.is_empty()).map(|entry| entry.id.as_str()),
    );
    ids.extend(own.iter().map(|effect| effect.text.id.as_str()));
    known(without, &ids)?;
    Ok(Options { skip: without.to_vec(), given, own, ..Options::default() })
}

/// The effects that the plant file gives; refuses ids that no effect has.
fn given(path: &Path, file: &PlantFile) -> Result<Vec<Term>> {
    let name = path.display().to_string();
    match file.plant.kind {
        Kind::SecondOrder => {
            let all: Vec<&str> = dynamic::effects::CATALOGUE.iter().map(|e| e.id).collect();
            file.check_effects(&name, &all)?;
            let names = |id: &str| dynamic::effects::effect(id).map_or(Vec::new(), |e| e.names());
            file.check_parameters(&name, names)?;
            Ok(dynamic::plant::given(&name, file)?)
        }
        Kind::Equations => Ok(Vec::new()),
        Kind::Linear => {
            file.check_effects(&name, &[linear::file::ID, linear::offset::ID])?;
            file.check_parameters(&name, linear::file::names)?;
            Ok(Vec::new())
        }
    }
}

/// The user's own effects, which take part beside a second-order plant or one in equations; the expressions of a plant are
/// read in any case.
fn own_effects(declared: Option<&Path>, name: &str, file: &PlantFile) -> Result<Vec<Arc<MotionEffect>>> {
    let (effects, texts) = match declared {
        Some(path) => (text_safety::path(path), fitter::plant::equations::read_declared(path)?),
        None => Default::default(),
    };
    match dynamic::equations::own(&effects, &texts, name, file) {
        Some(own) => Ok(own?),
        None if declared.is_none() => Ok(Vec::new()),
        None => Err(refused!(
            "effects of your own in motion need a plant with equations of motion (kind = \"second-order\" or \"equations\"), \
             and the plant is `linear`; state it in equations"
        )),
    }
}

/// The user's own simulation: the same rows, with `position` predicted.
fn own(path: &Path, recording: &DynamicRecording) -> Result<OwnSimulation> {
    let simulation = simulated::read(path)?;
    let positions = simulation.positions_for(&recording.t_s)?;
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
