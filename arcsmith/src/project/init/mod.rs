//! The text of a new project file, of a recording where there is one.

mod recognise;
mod size;

use std::path::Path;

use clap::ValueEnum;
use codegen::refused;
use fitter::mirror;
use fitter::table::{Naming, Table, Use};
use toml::Value;

use crate::terminal::Result;
use recognise::{Column, Role};

/// What a project is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Two eddy-current probes on either side of the axis
    Mirror,
    /// A sensor that reports the angle or position itself
    Direct,
    /// A direct sensor that turns round and round
    Encoder,
    /// A mechanism in motion
    Motion,
}

/// A new project file, and what is said of it.
pub struct New {
    /// Its text.
    pub text: String,
    /// What was seen in the recording.
    pub seen: Option<Seen>,
}

/// What was seen in a recording.
pub struct Seen {
    /// Its file.
    pub file: String,
    /// Number of rows.
    pub rows: usize,
    /// Columns that have the names of the format already.
    pub as_they_are: Vec<String>,
    /// Columns under other names, as `--map` has them.
    pub mapped: Vec<String>,
    /// Keys whose values were guessed.
    pub guessed: Vec<String>,
    /// The first point in time, where time is given so.
    pub started: Option<String>,
}

/// How a column is read: `name = { column = …, unit = … }`.
struct Reading {
    name: String,
    column: String,
    unit: Option<String>,
    /// What the guess of the unit rests on.
    guess: Option<String>,
}

impl Reading {
    fn line(&self) -> String {
        let unit = self.unit.as_ref().map_or(String::new(), |unit| format!(", unit = {}", quoted(unit)));
        let why = self.guess.as_ref().map_or(String::new(), |why| format!("   # guessed: {why}"));
        format!("{} = {{ column = {}{unit} }}{why}\n", self.name, quoted(&self.column))
    }

    fn as_mapping(&self) -> String {
        let unit = self.unit.as_ref().map_or(String::new(), |unit| format!(":{unit}"));
        format!("{}={}{unit}", self.name, self.column)
    }
}

/// The unit of a sensor or a plant: its key, its name, and what the guess rests on.
struct Own {
    key: &'static str,
    unit: String,
    guess: Option<String>,
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// The file of a project that has no recording yet.
pub fn without_recording(kind: Kind) -> New {
    let nominal = match kind {
        Kind::Mirror => mirror::PAIR_FILE,
        Kind::Direct => mirror::DIRECT_FILE,
        Kind::Encoder => mirror::ENCODER_FILE,
        Kind::Motion => MOTION,
    };
    New { text: whole("calibration.csv", kind, nominal, &[], &[]), seen: None }
}

/// The file of a project of the recording at `path`; `kind` where it was said.
pub fn of_recording(path: &Path, kind: Option<Kind>) -> Result<New> {
    let uses = |header: &fitter::table::Header| {
        let time = |name: &String| if recognise::is_time(name) { Use::Time } else { Use::Optional };
        Ok(header.names.iter().map(time).collect())
    };
    let table = Table::read(path, &Naming::default(), &uses, &mut |_| {})?;
    let columns = recognise::columns(&table);
    let kind = match kind.or_else(|| recognise::kind(&columns)) {
        Some(kind) => kind,
        None => {
            return Err(refused!("no columns of a sensor are recognised")
                .at(&table.file)
                .found(table.header.listed())
                .expected("x1_mm and x2_mm, or measured, with a reference; in motion drive and position")
                .mend("write a project without --from, and name its columns under [columns]"));
        }
    };
    let (readings, own) = match kind {
        Kind::Mirror => (size::of_pair(&table, &columns), Vec::new()),
        Kind::Direct | Kind::Encoder => size::of_direct(&table, &columns),
        Kind::Motion => size::of_motion(&columns),
    };
    let kind = if kind == Kind::Direct && size::turns(&table, &columns, &own) { Kind::Encoder } else { kind };
    let guessed: Vec<String> = (own.iter().filter(|own| own.guess.is_some()).map(|own| own.key.to_string()))
        .chain(readings.iter().filter(|one| one.guess.is_some()).map(|one| format!("columns.{}", one.name)))
        .collect();
    let shown = path.to_string_lossy();
    let text = whole(&shown, kind, &nominal(kind, &own), &readings, &guessed);
    let renamed = |column: &&Column| readings.iter().any(|one| one.column == column.in_file);
    let as_they_are = columns.iter().filter(|column| column.role.is_some() && !renamed(column));
    Ok(New {
        text,
        seen: Some(Seen {
            file: table.file.clone(),
            rows: table.rows,
            as_they_are: as_they_are.map(|column| column.in_file.clone()).collect(),
            mapped: readings.iter().map(Reading::as_mapping).collect(),
            guessed,
            started: table.started,
        }),
    })
}

/// The nominal model with the units that were recognised.
fn nominal(kind: Kind, own: &[Own]) -> String {
    let of = |key: &str| own.iter().find(|own| own.key == key);
    let line = |own: &Own| {
        let why = own.guess.as_ref().map_or(String::new(), |why| format!("   # guessed: {why}"));
        format!("{}{why}", quoted(&own.unit))
    };
    let mut text = match kind {
        Kind::Mirror => mirror::PAIR_FILE,
        Kind::Direct => mirror::DIRECT_FILE,
        Kind::Encoder => mirror::ENCODER_FILE,
        Kind::Motion => MOTION,
    }
    .to_string();
    if let Some(unit) = of("sensor.unit") {
        for example in ["unit = \"mm\"", "unit = \"deg\""] {
            text = text.replace(example, &format!("unit = {}", line(unit)));
        }
        if let Some(turn) = size::turn(&unit.unit) {
            text = text.replace("revolution = 360.0", &format!("revolution = {turn:?}"));
        }
    }
    for (key, example) in [("plant.position_unit", "\"arcsec\""), ("plant.drive_unit", "\"A\"")] {
        if let Some(unit) = of(key) {
            let name = key.trim_start_matches("plant.");
            text = text.replace(&format!("{name} = {example}"), &format!("{name} = {}", line(unit)));
        }
    }
    text
}

/// A mechanism in motion, as `plant.toml` has it.
const MOTION: &str = "\
# A mechanism in motion: position'' = -damping velocity - stiffness position + gain drive. The recording has the columns
# t_s, drive, position. Other structures: \"linear\", or \"equations\" of your own.

[plant]
kind = \"second-order\"
position_unit = \"arcsec\"
drive_unit = \"A\"
";

/// The whole text.
fn whole(recording: &str, kind: Kind, nominal: &str, readings: &[Reading], guessed: &[String]) -> String {
    let mut text =
        include_str!("../../../data/project-head.toml").replace("@RECORDINGS@", &quoted(recording));
    if kind != Kind::Motion {
        text += "# The coefficients of which firmware is made: \"fit\", or \"diagnosis\" with the physics that it named.\n";
        text += "coefficients = \"fit\"\n";
    }
    if !guessed.is_empty() {
        let list: Vec<String> = guessed.iter().map(|key| quoted(key)).collect();
        text += "# Units that were guessed from the size of the numbers. Look at each, correct it, and take it off this list:\n";
        text += "# `arcsmith check` fails as long as something stands on it.\n";
        text += &format!("guessed = [{}]\n", list.join(", "));
    }
    if !readings.is_empty() {
        text += "\n# Columns of the recording under other names, in other units.\n[columns]\n";
        text += &readings.iter().map(Reading::line).collect::<String>();
    }
    let rest = match kind {
        Kind::Motion => include_str!("../../../data/project-motion.toml"),
        _ => include_str!("../../../data/project-sensor.toml"),
    };
    text + "\n" + nominal.trim_end() + "\n" + rest
}

/// The number of a role in what is read, for the sizes of the numbers.
fn values<'a>(table: &'a Table, columns: &[Column], role: Role) -> Option<&'a [f64]> {
    let column = columns.iter().find(|column| column.role == Some(role))?;
    let found = table.columns.iter().find(|other| other.name == column.in_file)?;
    Some(&found.values)
}
