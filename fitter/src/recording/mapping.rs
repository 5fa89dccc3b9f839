//! Columns under other names and in other units: `x1_mm=Probe1:um`.

use std::str::FromStr;

use super::RecordingError;
use super::header::nearest;
use crate::error_model::Sensor;
use crate::units::{UNIT_NAMES, Unit};

/// One column of a file that stands for one of the recording format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mapping {
    /// The name in the recording format (`x1_mm`), or one that a further column is to have.
    pub target: String,
    /// The name in the file.
    pub source: String,
    /// The unit in the file, where it is not that of the target.
    pub unit: Option<String>,
}

impl std::fmt::Display for Mapping {
    /// As it is parsed.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let unit = self.unit.as_ref().map_or(String::new(), |unit| format!(":{unit}"));
        write!(f, "{}={}{unit}", self.target, self.source)
    }
}

impl FromStr for Mapping {
    type Err = String;

    /// `target=source`, or `target=source:unit`.
    fn from_str(text: &str) -> Result<Mapping, String> {
        let wrong =
            || format!("found `{text}`, expected target=column or target=column:unit (x1_mm=Probe1:um)");
        let (target, source) = text.split_once('=').ok_or_else(wrong)?;
        // The name in the file may hold a colon itself; a unit does not.
        let (source, unit) = match source.rsplit_once(':') {
            Some((source, unit)) if Unit::named(unit).is_some() || unit == "counts" => (source, Some(unit)),
            Some((_, unit)) if !unit.contains(' ') => {
                return Err(format!("found the unit `{unit}`, expected one of {UNIT_NAMES}, counts"));
            }
            _ => (source, None),
        };
        let (target, source) = (target.trim().to_string(), source.trim().to_string());
        if target.is_empty() || source.is_empty() {
            return Err(wrong());
        }
        Ok(Mapping { target, source, unit: unit.map(|unit| unit.trim().to_string()) })
    }
}

/// value → factor·value + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Conversion {
    pub factor: f64,
    pub offset: f64,
}

impl Mapping {
    /// The conversion into the target's unit: the end of its name, or that of the sensor. None without a unit.
    fn conversion(&self, file: &str, sensor: Option<&Sensor>) -> Result<Option<Conversion>, RecordingError> {
        let Some(name) = &self.unit else { return Ok(None) };
        let (stated, revolution) = match sensor {
            Some(Sensor::Direct { unit, revolution }) => (Some(unit.as_str()), *revolution),
            _ => (None, None),
        };
        let own = matches!(self.target.as_str(), "measured" | "reference");
        let target = if own { stated } else { self.target.rsplit_once('_').map(|(_, unit)| unit) };
        let unit_of = |name: &str| match (name, stated, revolution) {
            // A count, or any other unit of the sensor's own, is what its revolution says.
            (_, Some(stated), Some(turn)) if name == stated && Unit::named(name).is_none() => {
                Some(Unit::part_of_turn(turn))
            }
            _ => Unit::named(name),
        };
        if target == Some(name.as_str()) {
            return Ok(None);
        }
        let converted = target.and_then(unit_of).zip(unit_of(name)).and_then(|(to, from)| from.into(to));
        match converted {
            Some((factor, offset)) => Ok(Some(Conversion { factor, offset })),
            None => Err(RecordingError::MappedUnit {
                file: file.to_string(),
                target: self.target.clone(),
                found: name.clone(),
                expected: target.unwrap_or("a number without a unit").to_string(),
            }),
        }
    }
}

/// Gives the columns of a header the names that they are mapped to; beside them how each is converted.
pub(super) fn rename(
    file: &str,
    names: &mut [String],
    mappings: &[Mapping],
    sensor: Option<&Sensor>,
) -> Result<Vec<Option<Conversion>>, RecordingError> {
    let mut conversions = vec![None; names.len()];
    let original = names.to_vec();
    for mapping in mappings {
        let Some(index) = original.iter().position(|name| *name == mapping.source) else {
            return Err(RecordingError::MappedColumn {
                file: file.to_string(),
                target: mapping.target.clone(),
                column: mapping.source.clone(),
                found: original.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
                similar: nearest(&mapping.source, original.iter().map(String::as_str)).map(str::to_string),
            });
        };
        let twice = mappings.iter().filter(|other| other.target == mapping.target).count() > 1
            || mappings.iter().filter(|other| other.source == mapping.source).count() > 1;
        if twice {
            return Err(RecordingError::MappedTwice {
                target: mapping.target.clone(),
                column: mapping.source.clone(),
            });
        }
        names[index] = mapping.target.clone();
        conversions[index] = mapping.conversion(file, sensor)?;
    }
    // A column that has a mapped name of its own keeps it under another: the mapping says which is meant.
    for index in 0..names.len() {
        let mapped = mappings.iter().any(|mapping| mapping.target == names[index]);
        if mapped
            && original[index] == names[index]
            && names.iter().filter(|n| **n == names[index]).count() > 1
        {
            names[index] = format!("{}_in_file", names[index]);
        }
    }
    Ok(conversions)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mappings_are_parsed() {
        let parsed = |text: &str| text.parse::<Mapping>().map(|m| (m.target, m.source, m.unit));
        let some = |text: &str| Some(text.to_string());
        assert_eq!(parsed("x1_mm=Probe 1:um"), Ok(("x1_mm".into(), "Probe 1".into(), some("um"))));
        assert_eq!(parsed("pass=Run"), Ok(("pass".into(), "Run".into(), None)));
        assert_eq!(parsed("t_s=Time: elapsed"), Ok(("t_s".into(), "Time: elapsed".into(), None)));
        assert!(parsed("x1_mm").is_err() && parsed("=a").is_err());
        assert!(parsed("x1_mm=Probe1:parsec").unwrap_err().contains("um"));
    }
}
