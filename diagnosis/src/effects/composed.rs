//! Effects without a name: forms that a dependence on a recording's columns may have.

use std::sync::Arc;

use fitter::error_model::Sensor;
use physics::is_identifier;

use super::declared::{effects, of_sensor};
use super::read_once::ReadOnce;
use super::{CommonMode, Effect, Origin};

/// The forms of dependences on these columns, for a sensor, beside the ids that are taken; none of a column whose name
/// cannot stand in an expression.
pub fn composed(columns: &[&str], sensor: &Sensor, taken: &[&str]) -> Arc<[Effect]> {
    read("grammar.toml", physics::forms, columns, sensor, taken)
}

/// The same of curves.
pub fn curves(columns: &[&str], sensor: &Sensor, taken: &[&str]) -> Arc<[Effect]> {
    read("curves.toml", physics::curves, columns, sensor, taken)
}

/// The declarations of a file as effects, read once for each set of columns.
fn read(
    file: &'static str,
    declarations: fn(&[&str]) -> Vec<String>,
    columns: &[&str],
    sensor: &Sensor,
    taken: &[&str],
) -> Arc<[Effect]> {
    static READ: ReadOnce<(&str, bool, [Vec<String>; 3])> = ReadOnce::new();
    let (pair, unit) = of_sensor(sensor);
    let names = [&[unit], columns, taken].map(|names| names.iter().map(ToString::to_string).collect());
    READ.get((file, pair, names), || made(file, declarations, columns, (pair, unit), taken))
}

/// The declarations of a file as effects; none of the common mode's past: it averages the noise of the probes, which the
/// common mode holds, and so would be preferred to the leakage that is there.
fn made(
    file: &str,
    declarations: fn(&[&str]) -> Vec<String>,
    columns: &[&str],
    (pair, unit): (bool, &str),
    taken: &[&str],
) -> Vec<Effect> {
    let columns: Vec<&str> = columns.iter().copied().filter(|column| is_identifier(column)).collect();
    let effect = |declaration: String| {
        let origin = Origin::Form(declaration.clone());
        let effect = effects(file, &declaration, pair, unit, taken, origin).ok()?.pop();
        effect.filter(|effect| effect.common_mode != CommonMode::Remembered)
    };
    declarations(&columns).into_iter().filter_map(effect).collect()
}
