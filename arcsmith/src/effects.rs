//! `effects`: what can be hidden in a simulated device.

use serde_json::json;
use twin::dynamic::effects as moving;
use twin::effects as still;

use crate::terminal::{Common, summarise};

pub fn run(common: Common) {
    let text = || still::catalogue::listing() + "\nIn motion:\n" + &moving::catalogue::listing();
    summarise(common, known, text);
}

/// The catalogues as JSON.
fn known() -> serde_json::Value {
    let parameter = |name: &str, unit: &str, default: Option<f64>| json!({"name": name, "unit": unit, "default": default});
    let still = self::still::catalogue::ALL.iter().map(|effect| {
        let own = effect.parameters.iter().map(|p| parameter(p.name, p.unit, p.default));
        json!({"id": effect.id, "title": effect.title, "parameters": own.collect::<Vec<_>>()})
    });
    let moving = self::moving::catalogue::ALL.iter().map(|effect| {
        let own = effect.parameters.iter().map(|p| parameter(p.name, p.unit, p.default));
        json!({"id": effect.id, "title": effect.title, "parameters": own.collect::<Vec<_>>()})
    });
    json!({"static": still.collect::<Vec<_>>(), "dynamic": moving.collect::<Vec<_>>()})
}
