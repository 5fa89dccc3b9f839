//! Effects from declarations: those of the catalogue, and a file of the user's own.

mod explained;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use fitter::error_model::Sensor;
use fitter::message::Message;
use fitter::terms::Expressed;
use fitter::turn::Turn;
use physics::{DeclarationError, Declared, Role, Unit, Vocabulary, What};

use super::effect::Made;
use super::needs::Need;
use super::{CommonMode, Effect, Experiment, Facts, Origin, Place, read, report};
use crate::rows::Rows;

pub use explained::{Explained, Searched};

/// Whether a sensor is a pair of probes, and the unit of its position.
pub(super) fn of_sensor(sensor: &Sensor) -> (bool, &str) {
    match sensor {
        Sensor::EddyCurrentPair { .. } => (true, "arcsec"),
        Sensor::Direct { unit, .. } => (false, unit.as_str()),
    }
}

/// Reads a file of declared effects for a sensor.
///
/// # Errors
/// [`DeclarationError`], with the effect and the place in its expression.
pub fn read(file: &str, text: &str, sensor: &Sensor) -> Result<Vec<Effect>, DeclarationError> {
    let (pair, name) = of_sensor(sensor);
    let of_file = |what: String| DeclarationError::File { file: file.to_string(), what };
    Unit::parse(name).map_err(of_file)?;
    let catalogue = super::catalogue(sensor);
    let taken: Vec<&str> = catalogue.iter().map(|effect| effect.id.as_str()).collect();
    effects(file, text, pair, name, &taken, Origin::User)
}

/// Reads declared effects from a file.
///
/// # Errors
/// As [`read`], or the file cannot be read.
pub fn read_file(path: &Path, sensor: &Sensor) -> Result<Vec<Effect>, Message> {
    let file = fitter::text_safety::path(path);
    let text = fitter::input::toml(path, "file of effects (TOML)", &["effect"])?;
    read(&file, &text, sensor).map_err(Message::of)
}

/// The effects of the catalogue for a position in unit `name`.
pub(super) fn catalogued(text: &str, pair: bool, name: &str) -> Result<Vec<Effect>, DeclarationError> {
    effects("catalogue.toml", text, pair, name, &[], Origin::Catalogue)
}

/// Reads effects beside those of `taken` ids.
pub(super) fn effects(
    file: &str,
    text: &str,
    pair: bool,
    name: &str,
    taken: &[&str],
    origin: Origin,
) -> Result<Vec<Effect>, DeclarationError> {
    // A sensor's unit may be any name.
    let position = Unit::parse(name).unwrap_or_else(|_| Unit::named(name));
    let place = if name == "arcsec" { "deg" } else { name };
    let place_unit = if name == "arcsec" { Unit::named(place) } else { position.clone() };
    let column = |column: &str| match column {
        "angle" | "true_angle" => Some(position.clone()),
        "measured" if !pair => Some(position.clone()),
        "common_mode" => Some(Unit::named("um")),
        // The instrument that knows it is not there at run time.
        "reference" | "reference_arcsec" => None,
        _ => Expressed::observable(column, pair, name).ok().map(|(_, unit)| unit),
    };
    let vocabulary = Vocabulary {
        position: &position,
        places: (&place_unit, place),
        name,
        column: &column,
        known: &["angle", "common_mode", "direction", "t_s", "temperature_c", "coil_a", "cross_arcsec"],
        figure: &|figure| read::unit_of_figure(figure, &position),
        taken,
    };
    let declared = physics::declared(file, text, &vocabulary)?;
    let refuse = |id: String, what: String| DeclarationError::Effect { file: file.to_string(), id, what };
    let made = |declared: Declared| {
        let id = declared.id.clone();
        made(declared, pair, origin.clone()).map_err(|what| refuse(id, what))
    };
    declared.into_iter().map(made).collect()
}

/// An effect of its declaration.
fn made(declared: Declared, pair: bool, origin: Origin) -> Result<Effect, String> {
    let needs = declared.known.needs.iter().map(|need| Need::read(need)).collect::<Result<Vec<_>, _>>()?;
    let functions = declared.reported.iter().filter_map(|reported| match &reported.value {
        What::Named(name) => Some(name.clone()),
        What::Formula(_) => None,
    });
    let function = |name: String| {
        let known = report::named(&name).ok_or_else(|| format!("`{name}()` is no function of an effect"))?;
        Ok((name, known))
    };
    let functions = functions.map(function).collect::<Result<BTreeMap<_, _>, String>>()?;
    let found_by_fit: fn(&Turn) -> bool = match declared.known.found_by_fit.as_deref() {
        // The harmonics of a turn are the base.
        None | Some("harmonics") => |_| false,
        Some("lag") => |turn| turn.directions.lag_corrected,
        Some("slope") => |turn| turn.slope.is_some(),
        Some(other) => {
            return Err(format!("`fit` finds no `{other}`, expected `harmonics`, `lag` or `slope`"));
        }
    };
    let is_factor = |index: &usize| matches!(declared.parameters[*index].role, Role::Factor(_));
    let (factors, shaped) = (0..declared.parameters.len()).partition(is_factor);
    let facts = facts(&declared, origin)?;
    let of_sum = declared.parameters.iter().any(|parameter| matches!(parameter.role, Role::Sum(_)));
    let effect = Effect {
        made: Arc::new(Made { facts, declared, needs, functions, found_by_fit, pair, shaped, factors }),
    };
    if (effect.of_true_angle() || of_sum) && !repeats(&effect) {
        return Err("`true_angle` is not known at run time: it stands in a * sin(e) + b * cos(e) alone, e in proportion \
                    to it, and `sum` there alone"
            .into());
    }
    Ok(effect)
}

/// Whether all that it adds are harmonics of the true angle.
fn repeats(effect: &Effect) -> bool {
    let two = || vec![0.0, 1.0];
    let rows =
        Rows { pair: true, t_s: two(), pass: vec![0; 2], theta: two(), truth: two(), ..Rows::default() };
    let shape = vec![1.0; effect.made.shaped.len() + 1];
    effect.period(&rows, &shape).is_some()
}

fn facts(declared: &Declared, origin: Origin) -> Result<Facts, String> {
    let known = &declared.known;
    let columns = &declared.adds[0].sentence.columns;
    let place = match (&known.place[..], columns.first().map(String::as_str)) {
        ([on], _) => Place::on(on),
        ([on, times], _) => Place::product(on, times),
        (_, Some("angle" | "measured" | "true_angle") | None) => Place::on("angle_deg"),
        (_, Some("common_mode")) => Place::on("common_mode_um"),
        (_, Some(column)) => Place::on(column),
    };
    let of_others = |name: &String| read::Read::need_not_be(name).is_some();
    let probe = known.of_a_probe.as_ref().map(|name| {
        let found = declared.reported.iter().position(|reported| reported.written == *name);
        found.ok_or_else(|| format!("`{name}` is not among what is reported"))
    });
    let told_by = known.told_by.iter().map(|(experiment, how)| {
        let found = Experiment::named(experiment);
        let found = found
            .ok_or_else(|| format!("`{experiment}` is no experiment, expected {}", Experiment::names()))?;
        Ok((found, how.clone()))
    });
    let is = |role: fn(&Role) -> bool| declared.parameters.iter().any(|parameter| role(&parameter.role));
    let forms: Vec<String> = declared.adds.iter().map(|form| form.sentence.expression.to_string()).collect();
    Ok(Facts {
        id: declared.id.clone(),
        title: declared.title.clone(),
        formula: forms.join(", or "),
        source: known.source.clone(),
        size: if known.size.is_empty() { "as declared".into() } else { known.size.clone() },
        confused_with: known.confused_with.clone(),
        place,
        of_one_time: known.of_one_time,
        measured: known.measured.unwrap_or_else(|| columns.iter().all(of_others)),
        begins_at_a_row: is(|role| matches!(role, Role::Row)),
        repeatable: known.repeatable,
        shape_follows: is(|role| matches!(role, Role::Follows(..))),
        place_of_a_probe: probe.transpose()?,
        common_mode: match declared.adds[0].sentence.remembers() {
            false if columns[..] == ["common_mode"] => CommonMode::Alone,
            true if columns.iter().any(|column| column == "common_mode") => CommonMode::Remembered,
            _ => CommonMode::Otherwise,
        },
        origin,
        suggestions: known.readings.clone(),
        told_by: told_by.collect::<Result<_, String>>()?,
    })
}
