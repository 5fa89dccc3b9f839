//! The commands of a project: what each is given, what it reads and what it writes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use fitter::mirror::Mirror;

use super::FILE;
use super::file::{Nominal, Project, Target};
use super::options::Given;
use crate::diagnose;

/// A command that the project runs by itself where it is stale.
pub struct Step {
    /// `fit`, `diagnose` or `generate`.
    pub command: &'static str,
    /// The same, with the folder where there are several.
    pub name: String,
    /// The words of its command line, the program's name left out.
    pub words: Vec<String>,
    /// What it reads.
    pub inputs: Vec<Input>,
    /// What it writes: all that it may, of which some need not be there.
    pub outputs: Vec<PathBuf>,
    /// The steps whose results it reads.
    pub after: Vec<String>,
    /// The largest bound that is accepted, as an option's value: arcseconds, or a number with a unit.
    pub bound: Option<String>,
}

/// A file that a step reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Its path.
    pub path: String,
    /// The tables of it that matter, where it is the project file itself.
    pub tables: &'static [&'static str],
}

impl Input {
    fn file(path: &str) -> Input {
        Input { path: path.into(), tables: &[] }
    }

    /// A file, of which these tables matter where it is the project file.
    fn tables(path: &str, tables: &'static [&'static str]) -> Input {
        Input { path: path.into(), tables: if path == FILE { tables } else { &[] } }
    }

    /// Its name in messages and in the state.
    pub fn name(&self) -> String {
        match self.tables {
            [] => self.path.clone(),
            tables if *tables == Mirror::TABLES => format!("{FILE} (the mirror)"),
            PLANT => format!("{FILE} (the plant)"),
            _ => format!("{FILE} (the effects)"),
        }
    }
}

/// The tables of a plant.
const PLANT: &[&str] = &["plant", "state_space"];
/// The options whose values are files that are read.
const FILES: [&str; 2] = ["held_out", "simulated"];

impl Project {
    /// All steps, each after those whose results it reads.
    pub fn steps(&self) -> Vec<Step> {
        let mut steps = vec![self.diagnosis()];
        if matches!(self.nominal, Nominal::Mirror(_)) {
            steps.insert(0, self.fit(self.first_recording(), "fit".into(), self.fitted()));
            steps.extend(self.devices().map(|recording| {
                self.fit(recording, fit_of_device(recording), self.coefficients_of(recording))
            }));
            steps.extend(self.targets.iter().map(|target| self.generation(target)));
        }
        steps
    }

    /// The coefficients that `apply` and `generate` take.
    pub fn coefficients(&self) -> String {
        match self.of_diagnosis {
            false => self.fitted(),
            true => format!("{}/{}.coefficients.json", self.diagnosed(), stem(self.first_recording())),
        }
    }

    /// The coefficients of the fit.
    fn fitted(&self) -> String {
        format!("{}/coefficients.json", self.out)
    }

    /// Those of a device.
    fn coefficients_of(&self, recording: &str) -> String {
        format!("{}/devices/{}.json", self.out, stem(recording))
    }

    /// The recordings of the devices of all targets, each once.
    fn devices(&self) -> impl Iterator<Item = &str> {
        let all: BTreeSet<&str> =
            self.targets.iter().flat_map(|target| &target.devices).map(String::as_str).collect();
        all.into_iter()
    }

    /// The steps that write what a target is made of; of no target what the other commands take.
    pub fn origins(&self, target: Option<&Target>) -> Vec<String> {
        match target.map_or(&[][..], |target| &target.devices) {
            [] if self.of_diagnosis => vec!["diagnose".into()],
            [] => vec!["fit".into()],
            devices => devices.iter().map(|recording| fit_of_device(recording)).collect(),
        }
    }

    /// The folder of the diagnosis.
    pub fn diagnosed(&self) -> String {
        format!("{}/diagnosis", self.out)
    }

    /// The results of the diagnosis, one for each recording.
    pub fn diagnoses(&self) -> Vec<PathBuf> {
        let file = |recording: &String| format!("{}/{}.json", self.diagnosed(), stem(recording)).into();
        self.recordings.iter().map(file).collect()
    }

    fn fit(&self, recording: &str, name: String, out: String) -> Step {
        let mut inputs = vec![Input::file(recording)];
        inputs.extend(self.nominal_input());
        let mut given = offered(self, "fit", None);
        given.retain(|one| one.id != "out" && !one.positional);
        given.push(Given::option("out", &out));
        given.push(Given::places("recording", &[recording.to_string()]));
        Step {
            command: "fit",
            name,
            words: in_order("fit", given),
            inputs,
            outputs: vec![out.into()],
            after: Vec::new(),
            bound: None,
        }
    }

    fn diagnosis(&self) -> Step {
        let mut inputs: Vec<Input> = self.recordings.iter().map(|path| Input::file(path)).collect();
        inputs.extend(self.nominal_input());
        inputs.extend(self.effects.iter().map(|path| Input::tables(path, &["effect"])));
        let options = self.options.get("diagnose").into_iter().flatten();
        let read = options.filter(|one| FILES.contains(&one.id.as_str())).filter_map(|one| one.words.last());
        inputs.extend(read.map(|path| Input::file(path)));
        let ends = ["json", "html", "coefficients.json", "plant.toml", "simulated.csv"];
        let folder = self.diagnosed();
        let of = |recording: &String| ends.map(|end| format!("{folder}/{}.{end}", stem(recording)).into());
        Step {
            command: "diagnose",
            name: "diagnose".into(),
            words: words(self, "diagnose", None),
            inputs,
            outputs: self.recordings.iter().flat_map(of).collect(),
            after: Vec::new(),
            bound: None,
        }
    }

    fn generation(&self, target: &Target) -> Step {
        let bound = target.options.iter().find(|one| ["bound", "bound_arcsec"].contains(&one.id.as_str()));
        Step {
            command: "generate",
            name: format!("generate {}", target.out),
            words: words(self, "generate", Some(target)),
            inputs: self.sources(target).iter().map(|path| Input::file(path)).collect(),
            outputs: vec![Path::new(&target.out).join(CERTIFICATE)],
            after: self.origins(Some(target)),
            bound: bound.and_then(|one| one.words.last().cloned()),
        }
    }

    /// The coefficients that a target is made of.
    fn sources(&self, target: &Target) -> Vec<String> {
        match &target.devices[..] {
            [] => vec![self.coefficients()],
            devices => devices.iter().map(|recording| self.coefficients_of(recording)).collect(),
        }
    }

    fn nominal_input(&self) -> Option<Input> {
        Some(match &self.nominal {
            Nominal::Mirror(path) => Input::tables(path, &Mirror::TABLES),
            Nominal::Plant(path) => Input::tables(path, PLANT),
        })
    }
}

/// The file of a target that names and vouches for the others.
pub const CERTIFICATE: &str = "certificate.json";

/// The name of a recording's results.
pub fn stem(recording: &str) -> String {
    diagnose::stem(Path::new(recording))
}

/// The name of the step that fits a device.
fn fit_of_device(recording: &str) -> String {
    format!("fit {recording}")
}

/// The words of the command line with which a project runs a command.
pub fn words(project: &Project, command: &str, target: Option<&Target>) -> Vec<String> {
    in_order(command, offered(project, command, target))
}

/// A command line: options stand before what is known by its place.
fn in_order(command: &str, given: Vec<Given>) -> Vec<String> {
    let (places, options): (Vec<_>, Vec<_>) = given.into_iter().partition(|one| one.positional);
    let given = options.into_iter().chain(places).flat_map(|one| one.words);
    std::iter::once(command.to_string()).chain(given).collect()
}

/// Whether an option of a diagnosis holds for every unit of a fleet.
fn of_every_unit(one: &Given) -> bool {
    ["without", "order", "turn_harmonics", "harmonics"].contains(&one.id.as_str())
}

/// All that a project tells a command; of `generate`, `check` and `verify` about one target.
pub fn offered(project: &Project, command: &str, target: Option<&Target>) -> Vec<Given> {
    let of_table = |command: &str| project.options.get(command).cloned().unwrap_or_default();
    let map = || project.columns.iter().map(|mapping| Given::option("map", &mapping.to_string()));
    let nominal = match &project.nominal {
        Nominal::Mirror(path) => Given::option("mirror", path),
        Nominal::Plant(path) => Given::option("plant", path),
    };
    let device = || std::iter::once(nominal.clone()).chain(map());
    let effects = || project.effects.iter().map(|path| Given::option("effects", path));
    let coefficients = || Given::option("coefficients", &project.coefficients());
    let out = |own: &[Given], file: &str| {
        let own_out = own.iter().any(|one| one.id == "out");
        (!own_out).then(|| Given::option("out", &format!("{}/{file}", project.out)))
    };
    let first = vec![project.first_recording().to_string()];
    let verifications = project.verifications.clone();
    let mut all = Vec::new();
    match command {
        "diagnose" => {
            all.extend(device().chain(effects()));
            all.extend(of_table("diagnose"));
            all.push(Given::option("out", &project.diagnosed()));
            all.push(Given::places("recordings", &project.recordings));
        }
        _ if matches!(project.nominal, Nominal::Plant(_)) => {}
        "fleet" => {
            all.extend(device().chain(effects()));
            all.extend(of_table("diagnose").into_iter().filter(of_every_unit));
        }
        "fit" => {
            all.extend(device());
            all.extend(of_table("fit"));
            all.extend(out(&[], "coefficients.json"));
            all.push(Given::places("recording", &first));
        }
        "report" => {
            let own = of_table("report");
            let as_fitted =
                of_table("fit").into_iter().filter(|one| !own.iter().any(|other| other.id == one.id));
            all.extend(device());
            all.extend(as_fitted);
            all.extend(out(&own, "report.html"));
            all.extend(own.iter().cloned());
            all.push(Given::places("recordings", &[first, verifications].concat()));
        }
        "apply" => {
            let own = of_table("apply");
            let corrected = verifications.into_iter().next().map_or(first, |one| vec![one]);
            all.push(coefficients());
            all.extend(map());
            all.extend(out(&own, "angles.csv"));
            all.extend(own.iter().cloned());
            all.push(Given::places("recording", &corrected));
        }
        "explore" => all.push(coefficients()),
        "budget" => {
            all.push(coefficients());
            all.extend(target.iter().flat_map(|target| target.options.iter().cloned()));
        }
        "generate" | "check" | "verify" => {
            let devices = target.is_some_and(|target| !target.devices.is_empty());
            if !devices {
                all.push(coefficients());
            }
            if let Some(target) = target {
                let sources = project.sources(target);
                let sources = sources.iter().filter(|_| devices);
                all.extend(sources.map(|path| Given::option("devices", path)));
                all.extend(target.options.iter().cloned());
                all.push(Given::option("out", &target.out));
            }
            if command == "verify" {
                all.extend(of_table("verify"));
            }
        }
        _ => {}
    }
    all
}
