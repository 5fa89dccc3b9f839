//! Effects without a name: forms that a dependence on a recording's columns may have.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use fitter::error_model::Sensor;
use physics::is_identifier;

use super::declared::{effects, of_sensor};
use super::{CommonMode, Effect, Origin};

/// The forms of dependences on these columns, for a sensor, beside the ids that are taken; none of a column whose name
/// cannot stand in an expression. Read once for each set of columns: the units of a fleet have the same.
pub fn composed(columns: &[&str], sensor: &Sensor, taken: &[&str]) -> Arc<[Effect]> {
    type Known = BTreeMap<(bool, [Vec<String>; 3]), Arc<[Effect]>>;
    static READ: Mutex<Known> = Mutex::new(BTreeMap::new());
    let (pair, unit) = of_sensor(sensor);
    let key = [&[unit], columns, taken].map(|names| names.iter().map(ToString::to_string).collect());
    let made = || read("grammar.toml", physics::forms, columns, sensor, taken).into();
    // What a thread that failed left behind is whole: it is put in at once.
    Arc::clone(READ.lock().unwrap_or_else(PoisonError::into_inner).entry((pair, key)).or_insert_with(made))
}

/// The same of curves.
pub fn curves(columns: &[&str], sensor: &Sensor, taken: &[&str]) -> Vec<Effect> {
    read("curves.toml", physics::curves, columns, sensor, taken)
}

/// The declarations of a file as effects; none of the common mode's past: it averages the noise of the probes, which the
/// common mode holds, and so would be preferred to the leakage that is there.
fn read(
    file: &str,
    declarations: fn(&[&str]) -> Vec<String>,
    columns: &[&str],
    sensor: &Sensor,
    taken: &[&str],
) -> Vec<Effect> {
    let (pair, unit) = of_sensor(sensor);
    let columns: Vec<&str> = columns.iter().copied().filter(|column| is_identifier(column)).collect();
    let effect = |declaration: String| {
        let origin = Origin::Form(declaration.clone());
        let effect = effects(file, &declaration, pair, unit, taken, origin).ok()?.pop();
        effect.filter(|effect| effect.common_mode != CommonMode::Remembered)
    };
    declarations(&columns).into_iter().filter_map(effect).collect()
}
