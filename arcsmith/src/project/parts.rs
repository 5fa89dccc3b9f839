//! The parts of a project file, one function each.

use std::collections::BTreeMap;

use fitter::mirror::Mirror;
use fitter::table::{Mapping, nearest};

use super::FILE;
use super::file::{COMMANDS, Nominal, Target, normal};
use super::options::{self, Given};
use super::steps::stem;
use super::tree::{self, Entry, Item, Table};
use crate::terminal::Result;

/// The folder of a target that names none, as the command `generate` has it.
const GENERATED: &str = "generated";

/// The sensor or the plant: a path, or tables of the file itself.
pub fn nominal(root: &Table) -> Result<Nominal> {
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
pub fn effects(root: &Table) -> Result<Option<String>> {
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
pub fn columns(entry: &Entry) -> Result<Vec<Mapping>> {
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
pub fn guessed(root: &Table) -> Result<Vec<(usize, String)>> {
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

pub fn commands(root: &Table) -> Result<BTreeMap<&'static str, Vec<Given>>> {
    let mut all = BTreeMap::new();
    for (command, out_too) in COMMANDS {
        if let Some(entry) = root.get(command) {
            all.insert(command, options::read(entry.table(command)?, command, out_too)?);
        }
    }
    Ok(all)
}

/// The parts of a list of tables; a single table is a list of one.
pub fn list<'a>(root: &'a Table, key: &str) -> Vec<&'a Entry> {
    match root.get(key) {
        None => Vec::new(),
        Some(Entry { item: Item::List(items), .. }) => items.iter().collect(),
        Some(one) => vec![one],
    }
}

pub fn targets(root: &Table) -> Result<Vec<Target>> {
    let mut targets: Vec<(Target, usize)> = Vec::new();
    for entry in list(root, "generate") {
        let table = entry.table("generate")?;
        let mut options = options::read(table, "generate", true)?;
        let out = table.get("out").map_or(Ok(GENERATED.to_string()), |entry| entry.text("generate.out"))?;
        options.retain(|one| !["out", "devices"].contains(&one.id.as_str()));
        let line = table.get("out").map_or(entry.line, |entry| entry.line);
        if let Some((_, first)) = targets.iter().find(|(other, _)| normal(&other.out) == normal(&out)) {
            return Err(tree::refuse(line, format!("`generate.out`: two targets write to {out}"))
                .found(format!("it in line {first} too"))
                .expected("a folder of its own for each")
                .mend("give one of them another `out`"));
        }
        let devices = table.get("devices").map_or(Ok(Vec::new()), devices)?;
        let of_devices = options.iter().find(|one| ["margin", "page_address"].contains(&one.id.as_str()));
        if let Some(one) = of_devices.filter(|_| devices.is_empty()) {
            return Err(tree::refuse(
                one.line,
                format!("`generate.{}` belongs to a target with `devices`", one.id),
            )
            .mend("name the devices' recordings, or remove it"));
        }
        targets.push((Target { out, options, devices }, line));
    }
    Ok(targets.into_iter().map(|(target, _)| target).collect())
}

/// The recordings of the devices of a target: paths, or patterns such as `units/*.csv`.
fn devices(entry: &Entry) -> Result<Vec<String>> {
    let refuse = |what: String| tree::refuse(entry.line, format!("`generate.devices`: {what}"));
    let patterns = entry.texts("generate.devices")?;
    let files = codegen::devices::expand(&patterns).map_err(|_| {
        refuse(format!("no file matches {}", patterns.join(", ")))
            .expected("recordings, one of each device")
            .mend("correct the path")
    })?;
    let files: Vec<String> =
        files.iter().map(|path| normal(&path.to_string_lossy()).display().to_string()).collect();
    for (index, file) in files.iter().enumerate() {
        if let Some(other) = files[..index].iter().find(|other| stem(other) == stem(file)) {
            return Err(refuse(format!("{other} and {file} would be one device"))
                .expected("files of different names: a device is named after its recording")
                .mend("rename one of the two"));
        }
    }
    Ok(files)
}
