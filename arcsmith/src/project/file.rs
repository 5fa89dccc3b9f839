//! What stands in a project file, read and checked.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use fitter::input;
use fitter::mirror::Mirror;
use fitter::table::{Mapping, nearest};

use super::options::{self, Given};
use super::tree::{self, Entry, Item, Table};
use super::{FILE, steps};
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
const COMMANDS: [(&str, bool); 5] =
    [("fit", false), ("diagnose", false), ("apply", true), ("report", true), ("verify", false)];
/// The folder of the results where the file names none.
const RESULTS: &str = "results";
/// The folder of a target that names none, as the command `generate` has it.
const GENERATED: &str = "generated";

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
            nominal: nominal(&root)?,
            recordings,
            verifications: texts("verifications")?,
            effects: effects(&root)?,
            columns: root.get("columns").map_or(Ok(Vec::new()), columns)?,
            guessed: guessed(&root)?,
            out: root.get("out").map_or(Ok(RESULTS.to_string()), |entry| entry.text("out"))?,
            of_diagnosis,
            options: commands(&root)?,
            targets: targets(&root)?,
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
        let lines = list(root, "generate");
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

/// The sensor or the plant: a path, or tables of the file itself.
fn nominal(root: &Table) -> Result<Nominal> {
    let inline = Mirror::TABLES.iter().find_map(|table| root.get_key_value(*table));
    let plant = root.get("plant");
    let of_plant = |entry: &Entry| match &entry.item {
        Item::Table(_) => Ok(Nominal::Plant(FILE.into())),
        _ => Ok(Nominal::Plant(entry.text("plant")?)),
    };
    match (root.get("mirror"), inline, plant) {
        (Some(mirror), None, None) => Ok(Nominal::Mirror(mirror.text("mirror")?)),
        (None, Some(_), None) => Ok(Nominal::Mirror(FILE.into())),
        (None, None, Some(plant)) => of_plant(plant),
        (None, None, None) => Err(tree::refuse(1, "the nominal model is missing")
            .expected("[geometry] or [sensor] as in mirror.toml, [plant] as in plant.toml, or the path of such a file")
            .mend("add mirror = \"mirror.toml\", for example")),
        (Some(_), Some((table, entry)), _) => Err(tree::refuse(entry.line, format!("`mirror` and [{table}] are two models"))
            .mend("keep one of the two")),
        (mirror, inline, Some(plant)) => {
            let other = mirror.map(|_| "mirror").or(inline.map(|(table, _)| table.as_str())).unwrap_or_default();
            Err(tree::refuse(plant.line, format!("`plant` and `{other}` are two models")).mend("keep one of the two"))
        }
    }
}

/// The file of the user's effects, which may be the project file itself.
fn effects(root: &Table) -> Result<Option<String>> {
    match (root.get("effects"), root.get("effect")) {
        (Some(_), Some(inline)) => {
            Err(tree::refuse(inline.line, "`effects` and [[effect]] are two lists of effects")
                .mend("move these into the file, or remove `effects`"))
        }
        (Some(path), None) => Ok(Some(path.text("effects")?)),
        (None, inline) => Ok(inline.map(|_| FILE.to_string())),
    }
}

/// `[columns]`: `x1_mm = "Probe1:um"`, or `x1_mm = { column = "Probe1", unit = "um" }`.
fn columns(entry: &Entry) -> Result<Vec<Mapping>> {
    let mapping = |(name, entry): (&String, &Entry)| {
        let key = format!("columns.{name}");
        if let Item::Table(table) = &entry.item {
            tree::check_keys(table, &key, &["column", "unit"])?;
            let part =
                |part: &str| table.get(part).map(|entry| entry.text(&format!("{key}.{part}"))).transpose();
            let source = part("column")?.ok_or_else(|| entry.wrong(&key, "a `column` of the recording"))?;
            let unit = part("unit")?;
            if let Some(unit) = &unit {
                // The one place that knows which units there are.
                let checked: std::result::Result<Mapping, String> = format!("{name}=x:{unit}").parse();
                checked.map_err(|what| {
                    tree::refuse(entry.line, format!("`{key}`: {what}")).mend("correct the unit")
                })?;
            }
            return Ok(Mapping { target: name.clone(), source, unit });
        }
        let parsed: std::result::Result<Mapping, String> = format!("{name}={}", entry.text(&key)?).parse();
        parsed.map_err(|what| tree::refuse(entry.line, format!("`{key}`: {what}")).mend("correct it"))
    };
    entry.table("columns")?.iter().map(mapping).collect()
}

/// What was guessed: keys that the file has.
fn guessed(root: &Table) -> Result<Vec<(usize, String)>> {
    let Some(list) = root.get("guessed") else { return Ok(Vec::new()) };
    let mut known = Vec::new();
    for (table, entry) in root {
        if let Item::Table(keys) = &entry.item {
            known.extend(keys.keys().map(|key| format!("{table}.{key}")));
        }
    }
    for key in list.texts("guessed")? {
        if !known.contains(&key) {
            let mend =
                nearest(&key, known.iter().map(String::as_str)).map(|near| format!("did you mean `{near}`?"));
            return Err(tree::refuse(list.line, format!("`guessed` names `{key}`"))
                .expected("a key of this file, `columns.x1_mm` for example")
                .mend(mend.unwrap_or_else(|| "take it off the list".into())));
        }
    }
    Ok(list.texts("guessed")?.into_iter().map(|key| (list.line, key)).collect())
}

fn commands(root: &Table) -> Result<BTreeMap<&'static str, Vec<Given>>> {
    let mut all = BTreeMap::new();
    for (command, out_too) in COMMANDS {
        if let Some(entry) = root.get(command) {
            all.insert(command, options::read(entry.table(command)?, command, out_too)?);
        }
    }
    Ok(all)
}

/// The parts of a list of tables; a single table is a list of one.
fn list<'a>(root: &'a Table, key: &str) -> Vec<&'a Entry> {
    match root.get(key) {
        None => Vec::new(),
        Some(Entry { item: Item::List(items), .. }) => items.iter().collect(),
        Some(one) => vec![one],
    }
}

fn targets(root: &Table) -> Result<Vec<Target>> {
    let mut targets: Vec<(Target, usize)> = Vec::new();
    for entry in list(root, "generate") {
        let table = entry.table("generate")?;
        let mut options = options::read(table, "generate", true)?;
        let out = table.get("out").map_or(Ok(GENERATED.to_string()), |entry| entry.text("generate.out"))?;
        options.retain(|one| one.id != "out");
        let line = table.get("out").map_or(entry.line, |entry| entry.line);
        if let Some((_, first)) = targets.iter().find(|(other, _)| normal(&other.out) == normal(&out)) {
            return Err(tree::refuse(line, format!("`generate.out`: two targets write to {out}"))
                .found(format!("it in line {first} too"))
                .expected("a folder of its own for each")
                .mend("give one of them another `out`"));
        }
        targets.push((Target { out, options }, line));
    }
    Ok(targets.into_iter().map(|(target, _)| target).collect())
}
