//! Damage to coefficients and certificates (JSON) and to mirrors and plants (TOML).

use fitter::Coefficients;
use serde_json::{Value, json};

use super::draw::Draw;

/// Stands around what is no JSON value: a number too large for `f64`.
const RAW: &str = "@raw@";
/// Begins a key that is there already.
const TWICE: &str = "@twice@";

/// A JSON file, damaged one to three times; `terms` where it may be given further terms. A file of coefficients
/// that can still be read is often sealed again: its seal keeps no one from editing it.
pub fn json(draw: &mut Draw, text: &[u8], terms: bool) -> Vec<u8> {
    let Ok(mut root) = serde_json::from_slice::<Value>(text) else { return text.to_vec() };
    if terms && draw.one_in(2) {
        root["terms"] = Value::Array((0..1 + draw.below(3)).map(|_| term(draw)).collect());
        root["observed"] = json!({"temperature_c": [10, 40], "t_s": [0, 1000], "measured": [0, 360]});
        drop(root.as_object_mut().map(|fields| (fields.remove("joint_covariance"), fields.remove("turn"))));
    }
    (0..draw.below(4)).for_each(|_| damage(draw, &mut root));
    if draw.one_in(10) {
        return raw(&root);
    }
    drop(root.as_object_mut().map(|fields| fields.remove("sha256")));
    let text = raw(&root);
    match serde_json::from_slice::<Coefficients>(&text) {
        Ok(file) if draw.one_in(2) => file.to_sealed_json().into(),
        _ => text,
    }
}

fn raw(root: &Value) -> Vec<u8> {
    let text = format!("{root:#}");
    text.replace(&format!("\"{RAW}"), "").replace(&format!("{RAW}\""), "").replace(TWICE, "").into()
}

/// One place, found by going down from the root.
fn damage(draw: &mut Draw, value: &mut Value) {
    let deeper = !draw.one_in(6);
    match value {
        Value::Object(fields) if !fields.is_empty() => {
            let names: Vec<String> = fields.keys().cloned().collect();
            let name = draw.pick(&names);
            match draw.below(if deeper { 20 } else { 6 }) {
                0 => drop(fields.remove(name)),
                1 => drop(fields.insert(format!("{TWICE}{name}"), fields[name].clone())),
                2 => drop(fields.insert(name.clone(), other(draw))),
                _ => damage(draw, &mut fields[name]),
            }
        }
        Value::Array(items) if !items.is_empty() => {
            let at = draw.below(items.len());
            match draw.below(20) {
                0 => drop(items.remove(at)),
                1 => items.clear(),
                2 => {
                    let item = items[at].clone();
                    (0..*draw.pick(&[1, 2, 20, 300])).for_each(|_| items.push(item.clone()));
                }
                _ => damage(draw, &mut items[at]),
            }
        }
        Value::Number(right) if draw.one_in(2) => {
            *value = json!(right.as_f64().unwrap_or(1.0) * draw.factor())
        }
        Value::Number(_) => *value = number(draw),
        Value::String(_) if deeper => *value = Value::String(draw.text()),
        _ => *value = other(draw),
    }
}

fn other(draw: &mut Draw) -> Value {
    draw.pick(&[Value::Null, json!(true), json!("text"), json!([]), json!({}), json!(3), json!([[1e300]])])
        .clone()
}

fn number(draw: &mut Draw) -> Value {
    let number = draw.number();
    match number.parse::<f64>() {
        Ok(finite) if finite.is_finite() => json!(finite),
        _ => Value::String(format!("{RAW}{number}{RAW}")),
    }
}

/// A term of any operator, with plain and extreme numbers.
fn term(draw: &mut Draw) -> Value {
    let hostile = draw.text();
    let effect = if draw.one_in(3) { hostile.as_str() } else { "an_effect" };
    let observable = match draw.below(12) {
        0 => hostile.as_str(),
        1 => "measured",
        2 => "t_s",
        3 => "s",
        _ => "temperature_c",
    };
    let mut plain = || if draw.one_in(3) { number(draw) } else { json!(f64::from(draw.byte()) / 8.0 + 1.0) };
    let (a, b, c) = (plain(), plain(), plain());
    let whole = 1 + draw.below(4);
    let operator = match draw.below(9) {
        0 => json!({"kind": "product", "factors": [{"observable": observable, "mean": a, "power": whole}]}),
        1 => json!({"kind": "play", "observable": observable, "elements": [{"half_width": a}]}),
        2 => json!({"kind": "lag", "observable": observable, "time_constant_s": a, "mean": b}),
        3 => json!({"kind": "exponential", "observable": observable, "start": a, "scale": b}),
        4 => json!({"kind": "step", "observable": observable, "at": a}),
        5 => json!({"kind": "periodic", "period": a, "harmonics": [whole]}),
        6 => json!({"kind": "gaussian", "observable": observable, "centre": a, "width": b}),
        7 => json!({"kind": "hinge", "observable": observable, "threshold": a, "side": "above"}),
        _ => json!({"kind": "rate", "observable": observable}),
    };
    let coefficients = if operator["kind"] == "periodic" { json!([c, 1.0]) } else { json!([c]) };
    json!({"effect": effect, "scope": "device", "operator": operator, "coefficients": coefficients})
}

/// A TOML file, one to two of its lines damaged.
pub fn toml(draw: &mut Draw, text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    for _ in 0..1 + draw.below(2) {
        let keys: Vec<usize> = (0..lines.len()).filter(|&n| lines[n].contains(" = ")).collect();
        let at = if draw.one_in(8) || keys.is_empty() { draw.below(lines.len()) } else { *draw.pick(&keys) };
        let key = lines[at].split(" = ").next().unwrap_or_default().to_string();
        match draw.below(10) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[at].clone()),
            2 => lines[at] = draw.text(),
            3 => lines[at] = format!("{}{} = 1", key, draw.below(10)),
            4 => lines[at] = format!("{key} = [1, \"x\", {{}}]"),
            5 => lines[at] = format!("{key} = {}", Value::String(draw.text())),
            6 => {
                lines[at] =
                    format!("{key} = \"{}\"", draw.pick(&["turn", "mm", "deg", "encoder", "direct", "kg m²"]))
            }
            _ => lines[at] = format!("{key} = {}", draw.number()),
        }
        if lines.is_empty() {
            break;
        }
    }
    lines.join("\n").into()
}
