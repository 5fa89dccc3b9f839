//! Reading and writing the coefficients file.

use std::path::Path;

use serde::Serialize;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::{Coefficients, Diagnosed, Recorded, SCHEMA, VERSION_RECORDED as NEWEST};
use crate::basis::MAX_ORDER;
use crate::error_model::Sensor;
use crate::input::{self, FileError};
use crate::pretty::Pretty;
use crate::terms::Term;
use crate::text_safety::{self, is_identifier};
use crate::turn::Turn;

errors! {
    /// Why a coefficients file is refused.
    #[derive(Debug)]
    pub enum CoefficientsError {
        NotJson { file: String, line: usize, reason: String } =>
            at(file) line(line) says("is not JSON ({reason})") mend("the file is damaged, fit again");
        NotCoefficients { file: String, found: String } =>
            at(file) says("`schema` is {found}") expected("\"{SCHEMA}\"") mend("this is no coefficients file");
        Newer { file: String, found: u64 } =>
            at(file)
            says("was written as version {found} of the format and this program reads up to {NEWEST}")
            mend("use a newer program, or fit again with this one");
        Edited { file: String } =>
            at(file) says("was changed after it was written (its `sha256` is that of other contents)")
            mend("fit again, or take the line `sha256` out to use it as it stands");
        Damaged { file: String, reason: String } => at(file) says("is damaged ({reason})") mend("fit again");
    }
    from { File(FileError) }
}

/// Reads `coefficients.json`.
///
/// # Errors
/// One of [`CoefficientsError`], each a sentence that names the file: not JSON, not a coefficients file,
/// newer than this program, or damaged (a field missing, unknown or contradicting another).
pub fn read(path: &Path) -> Result<Coefficients, CoefficientsError> {
    read_with_text(path).map(|(coefficients, _)| coefficients)
}

/// As [`read`], with the text of the file.
///
/// # Errors
/// As [`read`].
pub fn read_with_text(path: &Path) -> Result<(Coefficients, String), CoefficientsError> {
    let text = input::parsed(path, "coefficients.json")?;
    Ok((parse(&text_safety::path(path), &text)?, text))
}

/// Parses the text of a coefficients file; `file` is the name that stands in messages.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &str, text: &str) -> Result<Coefficients, CoefficientsError> {
    input::expect(file, text.as_bytes(), input::Kind::Coefficients)?;
    let file = file.to_string();
    let value: Value = match serde_json::from_str(text) {
        Ok(value) => value,
        Err(error) => {
            let (line, reason) = (error.line(), error.to_string());
            return Err(CoefficientsError::NotJson { file, line, reason });
        }
    };
    match value.get("schema") {
        Some(Value::String(schema)) if schema == SCHEMA => {}
        Some(other) => return Err(CoefficientsError::NotCoefficients { file, found: other.to_string() }),
        None => return Err(CoefficientsError::NotCoefficients { file, found: "missing".to_string() }),
    }
    match value.get("version").and_then(Value::as_u64) {
        Some(version) if version > u64::from(NEWEST) => {
            return Err(CoefficientsError::Newer { file, found: version });
        }
        Some(version) if version > 0 => {}
        _ => {
            return Err(CoefficientsError::Damaged { file, reason: "`version` is no number".to_string() });
        }
    }
    if let Some(reason) = unsafe_text("", &value) {
        return Err(CoefficientsError::Damaged { file, reason });
    }
    let mut coefficients: Coefficients = match serde_json::from_str(text) {
        Ok(coefficients) => coefficients,
        Err(error) => return Err(CoefficientsError::Damaged { file, reason: error.to_string() }),
    };
    if let Some(reason) = contradiction(&coefficients) {
        return Err(CoefficientsError::Damaged { file, reason });
    }
    if let Some(written) = coefficients.sha256.take()
        && written != hash(&coefficients.to_json())
    {
        return Err(CoefficientsError::Edited { file });
    }
    Ok(coefficients)
}

fn hash(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Which text of the file could act in sources, pages or on a terminal, and why; `place` is where `value` stands.
fn unsafe_text(place: &str, value: &Value) -> Option<String> {
    let is_name = place.ends_with(".effect") || place.ends_with(".observable");
    let check = if is_name { text_safety::name } else { text_safety::sentence };
    match value {
        Value::String(text) => check(text).err().map(|reason| format!("`{place}` {reason}")),
        Value::Array(values) => {
            (0..).zip(values).find_map(|(k, value)| unsafe_text(&format!("{place}[{k}]"), value))
        }
        Value::Object(values) => values.iter().find_map(|(key, value)| {
            let inside = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
            let refused = |reason| format!("the name `{}` {reason}", text_safety::cell(key.as_bytes()));
            text_safety::name(key).err().map(refused).or_else(|| unsafe_text(&inside, value))
        }),
        _ => None,
    }
}

/// What in the file contradicts itself. (JSON has no NaN and no infinity, but numbers beyond the range of
/// `f64` would become one.)
fn contradiction(file: &Coefficients) -> Option<String> {
    let finite = |what: &str, values: &[f64]| {
        values.iter().find(|value| !value.is_finite()).map(|value| format!("{what} holds {value}"))
    };
    let base = &file.base;
    if base.coefficients.len() != base.order + 1 {
        let (order, found) = (base.order, base.coefficients.len());
        return Some(format!(
            "order {order} needs {} coefficients, `base.coefficients` has {found}",
            order + 1
        ));
    }
    if base.order > MAX_ORDER {
        return Some(format!("order {} is above {MAX_ORDER}", base.order));
    }
    let range = &file.valid_range;
    if range.from.partial_cmp(&range.to) != Some(std::cmp::Ordering::Less) {
        return Some(format!("`valid_range` runs from {} to {}", range.from, range.to));
    }
    if range.variable != file.sensor.reading_name() {
        return Some(format!("`valid_range.variable` is `{}`", range.variable));
    }
    match &file.sensor {
        Sensor::EddyCurrentPair { probe_distance_mm, initial_gap_mm } => {
            if !(probe_distance_mm.is_finite() && *probe_distance_mm > 0.0) {
                return Some(format!("`probe_distance_mm` is {probe_distance_mm}"));
            }
            if !(initial_gap_mm.is_finite() && *initial_gap_mm > 0.0) {
                return Some(format!("`initial_gap_mm` is {initial_gap_mm}"));
            }
        }
        Sensor::Direct { unit, revolution } => {
            if !is_identifier(unit) {
                return Some(format!("`unit` is `{unit}`, which cannot be part of a name"));
            }
            if revolution.is_some_and(|turn| !(turn.is_finite() && turn > 0.0)) {
                return Some("`revolution` is not above zero".to_string());
            }
        }
    }
    if let Some(identification) = &file.identification {
        let covariance = &identification.covariance;
        let n = base.coefficients.len();
        if !covariance.is_empty() && (covariance.len() != n || covariance.iter().any(|row| row.len() != n)) {
            return Some(format!("`covariance` is not {n} by {n}"));
        }
    }
    let (joint, n) = (&file.joint_covariance, file.count_of_all());
    if !joint.is_empty() && (joint.len() != n || joint.iter().any(|row| row.len() != n)) {
        return Some(format!(
            "`joint_covariance` is not {n} by {n}: the polynomial's coefficients and all terms'"
        ));
    }
    if let Some(reason) = file.turn.as_ref().and_then(Turn::contradiction) {
        return Some(reason);
    }
    if let Some(reason) = file.recorded.as_ref().and_then(Recorded::contradiction) {
        return Some(reason);
    }
    if let Some(reason) = file.diagnosis.as_ref().and_then(Diagnosed::contradiction) {
        return Some(reason);
    }
    finite("`base.coefficients`", &base.coefficients)
        .or_else(|| finite("`base.extrapolation`", &[base.extrapolation.constant, base.extrapolation.slope]))
        .or_else(|| file.terms.iter().find_map(Term::contradiction))
        .or_else(|| joint.iter().find_map(|row| finite("`joint_covariance`", row)))
        .or_else(|| finite("`base.centre`", &[base.centre]))
        .or_else(|| finite("`valid_range`", &[range.from, range.to]))
        .or_else(|| file.observed.iter().find_map(|(name, ends)| finite(&format!("`observed.{name}`"), ends)))
}

impl Coefficients {
    /// Whether the model can be evaluated, and the file read again once it is written.
    ///
    /// # Errors
    /// What in it contradicts itself.
    pub fn usable(&self) -> Result<(), String> {
        if let Some(reason) = contradiction(self) {
            return Err(reason);
        }
        // Numbers that JSON cannot hold may stand anywhere, in the statistics for example.
        match parse("", &self.to_sealed_json()) {
            Ok(_) => Ok(()),
            Err(CoefficientsError::Damaged { reason, .. }) => Err(reason),
            Err(error) => Err(error.to_string()),
        }
    }

    /// The file's text: JSON for people as well, every number with the digits that give it back exactly.
    pub fn to_json(&self) -> String {
        let mut text = Vec::new();
        let mut serializer = serde_json::Serializer::with_formatter(&mut text, Pretty::default());
        // Writing plain structs of numbers and strings into memory has no way to fail.
        if self.serialize(&mut serializer).is_err() {
            return String::new();
        }
        text.push(b'\n');
        String::from_utf8(text).unwrap_or_default()
    }

    /// The same with the hash of all that stands in it, so that [`read`] refuses the file once it was edited.
    /// Spaces and the order of keys may change.
    pub fn to_sealed_json(&self) -> String {
        let plain = Coefficients { sha256: None, ..self.clone() };
        Coefficients { sha256: Some(hash(&plain.to_json())), ..plain }.to_json()
    }
}
