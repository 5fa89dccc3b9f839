//! Columns under other names and in other units: `x1_mm=Probe1:um`.

use std::str::FromStr;

use super::RecordingError;
use super::header::nearest;
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

/// How the columns of a file are taken: under other names, and converted into the units that are expected.
#[derive(Debug, Clone, Copy, Default)]
pub struct Naming<'a> {
    /// Columns under other names.
    pub mappings: &'a [Mapping],
    /// Units of columns whose names do not end in one, such as `measured` or `position`, of which several are
    /// numbered (`position_2`).
    pub units: &'a [(&'a str, &'a str)],
    /// One turn in the first of these units, where it is a count.
    pub revolution: Option<f64>,
}

impl Naming<'_> {
    /// The conversion into the target's unit. None without a unit.
    fn conversion(&self, file: &str, mapping: &Mapping) -> Result<Option<Conversion>, RecordingError> {
        let Some(name) = &mapping.unit else { return Ok(None) };
        let ending = mapping.target.rsplit_once('_');
        let stem =
            ending.filter(|(_, end)| end.parse::<u32>().is_ok()).map_or(&*mapping.target, |(stem, _)| stem);
        let stated = self.units.iter().find(|(column, _)| *column == stem).map(|(_, unit)| *unit);
        let target = stated.or(ending.map(|(_, unit)| unit));
        let unit_of = |name: &str| match (self.units.first(), self.revolution) {
            // A count, or any other unit of the sensor's own, is what its revolution says.
            (Some((_, own)), Some(turn)) if name == *own && Unit::named(name).is_none() => {
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
                target: mapping.target.clone(),
                found: name.clone(),
                expected: target.unwrap_or("a number without a unit").to_string(),
            }),
        }
    }

    /// The names that the columns of a header are mapped to, and how each is converted.
    pub(super) fn rename(
        &self,
        file: &str,
        in_file: &[String],
    ) -> Result<(Vec<String>, Vec<Option<Conversion>>), RecordingError> {
        let (mut names, mut conversions) = (in_file.to_vec(), vec![None; in_file.len()]);
        for mapping in self.mappings {
            let Mapping { target, source, .. } = mapping;
            let Some(index) = in_file.iter().position(|name| name == source) else {
                return Err(RecordingError::MappedColumn {
                    file: file.to_string(),
                    mapping: format!("{target}={source}"),
                    found: in_file.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
                    similar: nearest(source, in_file.iter().map(String::as_str)).map(str::to_string),
                });
            };
            let count = |same: &dyn Fn(&Mapping) -> bool| self.mappings.iter().filter(|m| same(m)).count();
            if count(&|other| other.target == *target) > 1 || count(&|other| other.source == *source) > 1 {
                return Err(RecordingError::MappedTwice { target: target.clone(), column: source.clone() });
            }
            names[index] = target.clone();
            conversions[index] = self.conversion(file, mapping)?;
        }
        // A column that has a mapped name of its own keeps it under another: the mapping says which is meant.
        for index in 0..names.len() {
            let mapped = self.mappings.iter().any(|mapping| mapping.target == names[index]);
            let double = names.iter().filter(|name| **name == names[index]).count() > 1;
            if mapped && double && in_file[index] == names[index] {
                names[index] += "_in_file";
            }
        }
        Ok((names, conversions))
    }
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
