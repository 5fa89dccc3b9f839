//! Which column of a recording is which, by its name alone.

use fitter::table::Table;
use fitter::units::Unit;

use super::Kind;

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The time.
    Time,
    /// The number of the pass.
    Pass,
    /// The direction of motion.
    Direction,
    /// The commanded angle.
    Command,
    /// The first probe.
    First,
    /// The second probe.
    Second,
    /// What a sensor itself reports.
    Measured,
    /// The reference.
    Reference,
    /// The reference's second axis.
    Cross,
    /// A temperature.
    Temperature,
    /// The current of the coil.
    Coil,
    /// What drives a mechanism in motion.
    Drive,
    /// Where it is.
    Position,
}

/// A column of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The name in the file.
    pub in_file: String,
    /// What it is, where that is recognised.
    pub role: Option<Role>,
    /// The unit that its name says.
    pub unit: Option<String>,
}

/// Names of every role, in lower case, letters and digits alone; the first is that of the recording format.
const NAMES: [(Role, &[&str]); 13] = [
    (Role::Time, &["t", "time", "timestamp", "elapsed", "elapsedtime", "seconds", "datetime"]),
    (Role::Pass, &["pass", "run", "cycle", "sweep", "repeat", "passnumber", "passno", "series"]),
    (Role::Direction, &["direction", "dir", "sense"]),
    (
        Role::Command,
        &["command", "cmd", "setpoint", "commanded", "commandangle", "commandedangle", "nominal"],
    ),
    (
        Role::First,
        &[
            "x1",
            "probe1",
            "sensor1",
            "ch1",
            "channel1",
            "gap1",
            "displacement1",
            "disp1",
            "probea",
            "sensora",
        ],
    ),
    (
        Role::Second,
        &[
            "x2",
            "probe2",
            "sensor2",
            "ch2",
            "channel2",
            "gap2",
            "displacement2",
            "disp2",
            "probeb",
            "sensorb",
        ],
    ),
    (Role::Measured, &["measured", "encoder", "enc", "angle", "sensor", "reading", "resolver", "counts"]),
    (
        Role::Reference,
        &[
            "reference",
            "ref",
            "autocollimator",
            "collimator",
            "ac",
            "acx",
            "trueangle",
            "referenceangle",
            "interferometer",
        ],
    ),
    (Role::Cross, &["cross", "crossaxis", "autocollimatory", "acy"]),
    (
        Role::Temperature,
        &["temperature", "temp", "tplate", "platetemperature", "temperatureplate", "platetemp"],
    ),
    (Role::Coil, &["coil", "coilcurrent", "current", "icoil"]),
    (Role::Drive, &["drive", "voltage", "u", "force", "input"]),
    (Role::Position, &["position", "pos", "y", "output"]),
];

/// Whether a name is that of the time.
pub fn is_time(name: &str) -> bool {
    split(name, Role::Time).is_some()
}

/// The columns of a recording; no role is given twice, and a name of the recording format goes before others.
pub fn columns(table: &Table) -> Vec<Column> {
    let names = &table.header.in_file;
    let plain = |name: &String| Column { in_file: name.clone(), role: None, unit: None };
    let mut columns: Vec<Column> = names.iter().map(plain).collect();
    for (role, _) in NAMES {
        let known = |name: &String| split(name, role).map(|found| (name.clone(), found));
        let found: Vec<_> = names.iter().filter_map(known).collect();
        // The lowest place in the list of names is the surest.
        if let Some((name, (_, unit))) = found.into_iter().min_by_key(|(_, (place, _))| *place)
            && let Some(column) =
                columns.iter_mut().find(|column| column.in_file == name && column.role.is_none())
        {
            (column.role, column.unit) = (Some(role), unit);
        }
    }
    columns
}

/// The place of a name among those of a role, and the unit at its end.
fn split(name: &str, role: Role) -> Option<(usize, Option<String>)> {
    let known = NAMES.iter().find(|(other, _)| *other == role).map(|(_, names)| *names)?;
    let key = |text: &str| -> String {
        text.to_lowercase().chars().filter(|sign| sign.is_alphanumeric()).collect()
    };
    let place = |text: &str| {
        let key = key(text);
        known.iter().position(|name| *name == key)
    };
    if let Some(place) = place(name) {
        return Some((place, None));
    }
    let inner = name.trim_end().trim_end_matches([']', ')']);
    let (stem, unit) = inner.rsplit_once(['_', '[', '(', '/', ' '])?;
    let unit = unit.trim();
    (Unit::named(unit).is_some() || unit == "counts")
        .then(|| place(stem).map(|place| (place, Some(unit.to_lowercase()))))?
}

/// What a recording with these columns is of.
pub fn kind(columns: &[Column]) -> Option<Kind> {
    let has = |role: Role| columns.iter().any(|column| column.role == Some(role));
    if has(Role::First) && has(Role::Second) {
        Some(Kind::Mirror)
    } else if has(Role::Drive) && has(Role::Position) {
        Some(Kind::Motion)
    } else if (has(Role::Measured) || has(Role::Position)) && has(Role::Reference) {
        Some(Kind::Direct)
    } else {
        None
    }
}
