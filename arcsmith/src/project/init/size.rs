//! Which unit a column is in: what its name says, or else a guess from the size of its numbers.

use fitter::table::Table;
use fitter::units::{ARCSEC_PER_RAD, Unit};

use super::recognise::{Column, Role};
use super::{Own, Reading, values};

/// The probe distance of the example, for the size of an angle.
const PROBE_DISTANCE_MM: f64 = 12.0;
/// The units of an angle from which is guessed.
const ANGLES: [&str; 6] = ["arcsec", "deg", "urad", "mrad", "rad", "arcmin"];

/// How the columns of a pair of probes are read.
pub fn of_pair(table: &Table, columns: &[Column]) -> Vec<Reading> {
    let mut readings = common(table, columns);
    let probes = [(Role::First, "x1_mm"), (Role::Second, "x2_mm")];
    let reach =
        probes.iter().filter_map(|(role, _)| values(table, columns, *role)).map(largest).fold(0.0, f64::max);
    let length = length(reach);
    for (role, name) in probes {
        let why = || format!("the largest number of the probes is {}", round(reach));
        readings.extend(reading(columns, role, name, || (length.to_string(), why())));
    }
    let unit = readings.iter().find(|one| one.name == "x1_mm").and_then(|one| one.unit.clone());
    let mm =
        unit.and_then(|unit| Unit::named(&unit)?.into(Unit::named("mm")?)).map_or(1.0, |(factor, _)| factor);
    let turned = match (values(table, columns, Role::First), values(table, columns, Role::Second)) {
        (Some(first), Some(second)) => {
            let s: Vec<f64> = first.iter().zip(second).map(|(a, b)| mm * (b - a)).collect();
            span(&s) / PROBE_DISTANCE_MM * ARCSEC_PER_RAD
        }
        _ => 0.0,
    };
    let angles = [(Role::Reference, "reference_arcsec"), (Role::Command, "command_deg")];
    for (role, name) in angles {
        let Some(own) = values(table, columns, role).map(span) else { continue };
        let why = || format!("it runs over {}, the probes over {} arcsec", round(own), round(turned));
        readings.extend(reading(columns, role, name, || (angle(own, turned).to_string(), why())));
    }
    let cross = || ("arcsec".to_string(), "as autocollimators report".to_string());
    readings.extend(reading(columns, Role::Cross, "cross_arcsec", cross));
    readings
}

/// How the columns of a direct sensor are read, and its unit.
pub fn of_direct(table: &Table, columns: &[Column]) -> (Vec<Reading>, Vec<Own>) {
    let mut readings = common(table, columns);
    let role = if has(columns, Role::Measured) { Role::Measured } else { Role::Position };
    let stated =
        |role: Role| columns.iter().find(|column| column.role == Some(role)).and_then(|c| c.unit.clone());
    let measured = values(table, columns, role).unwrap_or_default();
    let reference = values(table, columns, Role::Reference).unwrap_or_default();
    // Counts are converted into the unit of the reference, since what is corrected is an angle.
    let bits =
        bits(measured).filter(|_| stated(role).is_none_or(|unit| unit == "counts") && no_counts(reference));
    let (unit, guess) = match stated(Role::Reference).or_else(|| stated(role).filter(|_| bits.is_none())) {
        Some(unit) => (unit, None),
        None => guessed_unit(span(if bits.is_some() { reference } else { measured })),
    };
    let counts = || {
        let bits = bits.unwrap_or_default();
        (format!("{bits}bit"), format!("whole numbers up to {}", round(largest(measured))))
    };
    match bits {
        Some(_) => {
            let column = columns.iter().find(|column| column.role == Some(role));
            let column = column.map_or(String::new(), |column| column.in_file.clone());
            let (unit, why) = counts();
            readings.push(Reading { name: "measured".into(), column, unit: Some(unit), guess: Some(why) });
        }
        None => readings
            .extend(reading(columns, role, "measured", || (unit.clone(), "as the sensor's unit".into()))),
    }
    readings.extend(reading(columns, Role::Reference, "reference", || {
        (unit.clone(), "as the sensor's unit".into())
    }));
    // What is in the sensor's own unit is guessed once, with that.
    for one in readings.iter_mut().filter(|one| one.unit.as_ref() == Some(&unit)) {
        one.guess = None;
    }
    (readings, vec![Own { key: "sensor.unit", unit, guess }])
}

/// How the columns of a mechanism in motion are read, and the units of the plant.
pub fn of_motion(columns: &[Column]) -> (Vec<Reading>, Vec<Own>) {
    let mut readings = Vec::new();
    readings.extend(reading(columns, Role::Time, "t_s", || ("s".into(), "as no unit is named".into())));
    let mut own = Vec::new();
    let units = [
        (Role::Position, "position", "plant.position_unit", "arcsec"),
        (Role::Drive, "drive", "plant.drive_unit", "A"),
    ];
    for (role, name, key, usual) in units {
        let stated =
            columns.iter().find(|column| column.role == Some(role)).and_then(|column| column.unit.clone());
        let guess = stated.is_none().then(|| "the recording names no unit".to_string());
        let unit = stated.unwrap_or_else(|| usual.to_string());
        readings.extend(reading(columns, role, name, || (unit.clone(), String::new())).map(|one| Reading {
            guess: None,
            unit: None,
            ..one
        }));
        own.push(Own { key, unit, guess });
    }
    (readings, own)
}

/// Whether the readings of a direct sensor run over most of a turn.
pub fn turns(table: &Table, columns: &[Column], own: &[Own]) -> bool {
    const MOST: f64 = 0.9;
    let reference = values(table, columns, Role::Reference).map(span).unwrap_or_default();
    own.first().and_then(|own| turn(&own.unit)).is_some_and(|turn| reference > MOST * turn)
}

/// One turn in a unit of angle.
pub fn turn(unit: &str) -> Option<f64> {
    let (factor, _) = Unit::named("turn")?.into(Unit::named(unit)?)?;
    // A turn of 360 is 360, whatever the conversion rounds.
    Some(if (factor - factor.round()).abs() < 1e-9 * factor { factor.round() } else { factor })
}

/// What every calibration has: time, pass, direction, temperature, current.
fn common(table: &Table, columns: &[Column]) -> Vec<Reading> {
    let size = |role: Role| values(table, columns, role).map(largest).unwrap_or_default();
    let mut readings = Vec::new();
    let seconds = || ("s".to_string(), "as no unit is named".to_string());
    let time = reading(columns, Role::Time, "t_s", seconds);
    // Points in time are in no unit.
    let in_seconds = |one: Reading| Reading { unit: None, guess: None, ..one };
    let given = table.started.is_some() || size(Role::Time) > NO_SECONDS;
    readings.extend(time.map(|one| if given { in_seconds(one) } else { one }));
    for (role, name) in [(Role::Pass, "pass"), (Role::Direction, "direction")] {
        readings.extend(reading(columns, role, name, || (String::new(), String::new())).map(in_seconds));
    }
    let (hot, strong) = (size(Role::Temperature), size(Role::Coil));
    let temperature = if hot > COLDEST_IN_KELVIN { "k" } else { "c" };
    let why = |number: f64| format!("its largest number is {}", round(number));
    readings.extend(reading(columns, Role::Temperature, "temperature_c", || (temperature.into(), why(hot))));
    let current = if strong > MOST_AMPERES { "ma" } else { "a" };
    readings.extend(reading(columns, Role::Coil, "coil_a", || (current.into(), why(strong))));
    readings
}

/// Times beyond are counts since 1970, which the reader of recordings converts.
const NO_SECONDS: f64 = 1e11;
/// No calibration is made at so many degrees Celsius: larger numbers are kelvin.
const COLDEST_IN_KELVIN: f64 = 200.0;
/// More than a small voice coil takes.
const MOST_AMPERES: f64 = 20.0;

fn has(columns: &[Column], role: Role) -> bool {
    columns.iter().any(|column| column.role == Some(role))
}

/// How the column of a role is read as `name`; none where it has that name. `guess` is the unit where its name says none,
/// and why.
fn reading(
    columns: &[Column],
    role: Role,
    name: &str,
    guess: impl FnOnce() -> (String, String),
) -> Option<Reading> {
    let column = columns.iter().find(|column| column.role == Some(role))?;
    if column.in_file == name {
        return None;
    }
    let (unit, guess) = match &column.unit {
        Some(unit) => (unit.clone(), None),
        None => {
            let (unit, why) = guess();
            (unit, Some(why))
        }
    };
    Some(Reading { name: name.to_string(), column: column.in_file.clone(), unit: Some(unit), guess })
}

/// The unit of displacements that reach so far: those of probes are within a few millimetres.
fn length(reach: f64) -> &'static str {
    const FEW_MM: f64 = 5.0;
    match reach {
        _ if reach < 1e-3 * FEW_MM => "m",
        _ if reach < FEW_MM => "mm",
        _ if reach < 1e3 * FEW_MM => "um",
        _ => "nm",
    }
}

/// The unit in which an angle that runs over `own` comes nearest to `arcsec`.
fn angle(own: f64, arcsec: f64) -> &'static str {
    let distance = |unit: &str| {
        let factor = Unit::named(unit).zip(Unit::named("arcsec")).and_then(|(from, to)| from.into(to));
        factor.map_or(f64::INFINITY, |(factor, _)| (factor * own / arcsec).ln().abs())
    };
    ANGLES.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or("arcsec")
}

/// The unit of a direct sensor whose readings run over so much.
fn guessed_unit(own: f64) -> (String, Option<String>) {
    let radians = (5.5..7.0).contains(&own);
    let unit = if radians {
        "rad"
    } else if own > 90.0 {
        "deg"
    } else {
        "mm"
    };
    (unit.into(), Some(format!("the readings run over {}", round(own))))
}

/// The bits of a word, where all readings are whole numbers that fill one.
fn bits(values: &[f64]) -> Option<u32> {
    let whole = !values.is_empty() && values.iter().all(|value| value.fract() == 0.0 && *value >= 0.0);
    let bits = (largest(values) + 1.0).log2().ceil() as u32;
    (whole && (10..=24).contains(&bits)).then_some(bits)
}

/// Whether these are no counts themselves.
fn no_counts(values: &[f64]) -> bool {
    bits(values).is_none()
}

fn finite(values: &[f64]) -> impl Iterator<Item = f64> {
    values.iter().copied().filter(|value| value.is_finite())
}

fn largest(values: &[f64]) -> f64 {
    finite(values).map(f64::abs).fold(0.0, f64::max)
}

fn span(values: &[f64]) -> f64 {
    let (low, high) =
        finite(values).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    (high - low).max(0.0)
}

fn round(value: f64) -> String {
    fitter::figures::plain(value)
}
