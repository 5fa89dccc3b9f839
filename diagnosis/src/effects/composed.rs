//! Effects without a name: forms that a dependence on a recording's columns may have.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use fitter::error_model::Sensor;
use physics::is_identifier;

use super::declared::{effects, of_sensor};
use super::{CommonMode, Effect, Origin};

/// The forms of dependences on these columns, for a sensor, beside the ids that are taken; none of a column whose name
/// cannot stand in an expression, nor of the common mode's past: it averages the noise of the probes, which the common mode
/// holds, and so would be preferred to the leakage that is there. Read once for each set of columns: the units of a fleet have
/// the same.
pub fn composed(columns: &[&str], sensor: &Sensor, taken: &[&str]) -> Arc<[Effect]> {
    type Known = BTreeMap<(bool, [Vec<String>; 3]), Arc<[Effect]>>;
    static READ: Mutex<Known> = Mutex::new(BTreeMap::new());
    let (pair, unit) = of_sensor(sensor);
    let columns: Vec<&str> = columns.iter().copied().filter(|column| is_identifier(column)).collect();
    let key = [&[unit], &columns[..], taken].map(|names| names.iter().map(ToString::to_string).collect());
    let read = |declaration: String| {
        let origin = Origin::Form(declaration.clone());
        let effect = effects("grammar.toml", &declaration, pair, unit, taken, origin).ok()?.pop();
        effect.filter(|effect| effect.common_mode != CommonMode::Remembered)
    };
    let made = || physics::forms(&columns).into_iter().filter_map(read).collect();
    // What a thread that failed left behind is whole: it is put in at once.
    Arc::clone(READ.lock().unwrap_or_else(PoisonError::into_inner).entry((pair, key)).or_insert_with(made))
}
