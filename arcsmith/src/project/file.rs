//! What stands in a project file, read and checked.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use fitter::input;
use fitter::mirror::Mirror;
use fitter::table::Mapping;

use super::options::{self, Given};
use super::tree::{self, Item, Table};
use super::{FILE, parts, steps};
use crate::terminal::Result;

/// A project.
pub struct Project {
    /// What the recordings are of.
    pub nominal: Nominal,
    /// The recordings that are diagnosed; of a sensor the first is fitted.
    pub recordings: Vec<String>,
    /// Recordings that verify the correction.
    pub verifications: Vec<String>,
    /// The file with the user's effects.
    pub effects: Option<String>,
    /// Columns under other names, in other units.
    pub columns: Vec<Mapping>,
    /// Keys whose values were guessed and not confirmed, and the line on which that stands.
    pub guessed: Vec<(usize, String)>,
    /// The folder of the results.
    pub out: String,
    /// Whether firmware is made of the coefficients of the diagnosis, not of those of the fit.
    pub of_diagnosis: bool,
    /// Options by command.
    pub options: BTreeMap<&'static str, Vec<Given>>,
    /// What is generated.
    pub targets: Vec<Target>,
}

/// The nominal model, and the file in which it stands: that may be the project file itself.
#[derive(Debug, Clone, PartialEq)]
pub enum Nominal {
    /// A sensor.
    Mirror(String),
    /// A mechanism in motion.
    Plant(String),
}

/// One of the tables `[[generate]]`.
pub struct Target {
    /// The folder.
    pub out: String,
    /// The options.
    pub options: Vec<Given>,
    /// The recordings of the devices that get a page of coefficients each; blank where there is one routine alone.
    pub devices: Vec<String>,
}

const KEYS: [&str; 20] = [
    "recordings",
    "verifications",
    "mirror",
    "plant",
    "effects",
    "out",
    "coefficients",
    "guessed",
    "columns",
    "fit",
    "apply",
    "report",
    "diagnose",
    "verify",
    "generate",
    "geometry",
    "reference",
    "sensor",
    "effect",
    "state_space",
];
/// The commands whose options have a table, and whether that may say where they write.
pub const COMMANDS: [(&str, bool); 5] =
    [("fit", false), ("diagnose", false), ("apply", true), ("report", true), ("verify", false)];
/// The folder of the results where the file names none.
const RESULTS: &str = "results";

impl Project {
    /// Whether the current folder has a project file.
    pub fn is_here() -> bool {
        Path::new(FILE).is_file()
    }

    /// Reads the project file of the current folder.
    pub fn read() -> Result<Project> {
        Project::parse(&input::parsed(Path::new(FILE), "project file (TOML)")?)
    }

    fn parse(text: &str) -> Result<Project> {
        let root = tree::parse(text)?;
        tree::check_keys(&root, "", &KEYS)?;
        let texts = |key: &str| root.get(key).map_or(Ok(Vec::new()), |entry| entry.texts(key));
        let recordings = texts("recordings")?;
        if recordings.is_empty() {
            return Err(tree::refuse(
                root.get("recordings").map_or(1, |entry| entry.line),
                "`recordings` is missing",
            )
            .expected("the calibration recording, for example recordings = [\"calibration.csv\"]")
            .mend("add it"));
        }
        let of_diagnosis = match root.get("coefficients").map(|entry| (entry, &entry.item)) {
            None => false,
            Some((_, Item::Text(text))) if text == "fit" => false,
            Some((_, Item::Text(text))) if text == "diagnosis" => true,
            Some((entry, _)) => return Err(entry.wrong("coefficients", "\"fit\" or \"diagnosis\"")),
        };
        let project = Project {
            nominal: parts::nominal(&root)?,
            recordings,
            verifications: texts("verifications")?,
            effects: parts::effects(&root)?,
            columns: root.get("columns").map_or(Ok(Vec::new()), parts::columns)?,
            guessed: parts::guessed(&root)?,
            out: root.get("out").map_or(Ok(RESULTS.to_string()), |entry| entry.text("out"))?,
            of_diagnosis,
            options: parts::commands(&root)?,
            targets: parts::targets(&root)?,
        };
        if project.nominal == Nominal::Mirror(FILE.into()) {
            Mirror::parse(FILE, &input::section(text, &Mirror::TABLES))?;
        }
        project.check(&root)?;
        Ok(project)
    }

    /// Refuses what the commands would refuse, before one of them is run.
    fn check(&self, root: &Table) -> Result<()> {
        let line = |key: &str| root.get(key).map_or(1, |entry| entry.line);
        let of_sensors = ["fit", "apply", "report", "generate", "verify"];
        if matches!(self.nominal, Nominal::Plant(_))
            && let Some(key) = of_sensors.iter().find(|key| root.contains_key(**key))
        {
            return Err(tree::refuse(
                line(key),
                format!("`{key}` needs a sensor, and the project has a plant"),
            )
            .mend("remove the table, or state the mirror in place of the plant"));
        }
        for (command, _) in COMMANDS {
            if self.options.contains_key(command) && command != "verify" {
                options::check(command, &steps::offered(self, command, None), line(command))?;
            }
        }
        let lines = parts::list(root, "generate");
        for (target, line) in self.targets.iter().zip(lines.iter().map(|entry| entry.line)) {
            options::check("generate", &steps::offered(self, "generate", Some(target)), line)?;
            options::check("verify", &steps::offered(self, "verify", Some(target)), line)?;
        }
        Ok(())
    }

    /// The recordings by which the fit is named.
    pub fn first_recording(&self) -> &str {
        self.recordings.first().map_or("", String::as_str)
    }
}

/// A path without `.` and without what goes back and forth.
pub fn normal(path: &str) -> PathBuf {
    let mut whole = PathBuf::new();
    for part in Path::new(path).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if whole.file_name().is_some() => drop(whole.pop()),
            part => whole.push(part),
        }
    }
    whole
}
