//! The nominal mirror, `mirror.toml`: what the simulation believes of the sensor and its geometry.

use std::path::Path;

use toml::{Table, Value};

use crate::coefficients::Reference;
use crate::error_model::Sensor;
use crate::input;
use crate::keys::{self, KeyError, quoted};
use crate::text_safety::is_identifier;
use crate::units::Unit;

/// What `init` writes for two eddy-current probes.
pub const PAIR_FILE: &str = include_str!("../data/mirror-pair.toml");
/// What it writes for a sensor that reports the angle or position itself.
pub const DIRECT_FILE: &str = include_str!("../data/mirror-direct.toml");
/// What it writes for an encoder.
pub const ENCODER_FILE: &str = include_str!("../data/mirror-encoder.toml");
/// The JSON schema of a mirror file.
pub const SCHEMA: &str = include_str!("../data/mirror.schema.json");

/// The nominal sensor and its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Mirror {
    /// The sensor and its geometry.
    pub sensor: Sensor,
    /// What the file states of the reference, in [`Sensor::error_unit`].
    pub reference: Reference,
}

const KEYS: [(&str, &[&str]); 3] = [
    ("geometry", &["probe_distance_mm", "initial_gap_mm"]),
    (
        "reference",
        &["accuracy_arcsec", "accuracy", "coverage_factor", "repeatability_arcsec", "repeatability"],
    ),
    ("sensor", &["kind", "unit", "revolution"]),
];

impl Mirror {
    /// The tables of the file.
    pub const TABLES: [&'static str; 3] = ["geometry", "reference", "sensor"];

    /// The mirror of Fan et al. (2019): probes 12 mm apart, 0.3 mm from their pads, an autocollimator of 1″.
    pub fn paper() -> Mirror {
        Mirror {
            sensor: Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
            reference: Reference { accuracy: Some(1.0), ..Reference::default() },
        }
    }

    /// Reads `mirror.toml`.
    ///
    /// # Errors
    /// One of [`KeyError`]; an unknown key is refused and the nearest known one suggested.
    pub fn read(path: &Path) -> Result<Mirror, KeyError> {
        keys::read(path, "mirror.toml", &Mirror::TABLES, Mirror::parse)
    }

    /// Parses the text of a mirror file; `file` is the name that stands in messages.
    ///
    /// # Errors
    /// As [`Mirror::read`].
    pub fn parse(file: &str, text: &str) -> Result<Mirror, KeyError> {
        input::expect(file, text.as_bytes(), input::Kind::Mirror)?;
        let table: Table = text.parse().map_err(|error| match KeyError::syntax(file, text, &error) {
            KeyError::Syntax { file, line, reason } => {
                KeyError::Syntax { file, line, reason: format!("is not TOML ({reason})") }
            }
            other => other,
        })?;
        let reader = Reader { file, table: &table };
        reader.check_keys()?;
        let kind = match reader.get("sensor.kind") {
            None => "eddy-current-pair",
            Some(Value::String(kind)) => kind.as_str(),
            Some(other) => return Err(reader.wrong("sensor.kind", other, KINDS)),
        };
        let sensor = match kind {
            "eddy-current-pair" => Sensor::EddyCurrentPair {
                probe_distance_mm: reader.positive("geometry.probe_distance_mm", "the distance d in mm")?,
                initial_gap_mm: reader.positive("geometry.initial_gap_mm", "the gap at rest in mm")?,
            },
            "direct" => Sensor::Direct {
                unit: reader.unit()?,
                revolution: reader.optional("sensor.revolution", "one turn")?,
            },
            _ => return Err(reader.wrong("sensor.kind", &Value::String(kind.to_string()), KINDS)),
        };
        let reference = reader.reference(&sensor)?;
        Ok(Mirror { sensor, reference })
    }
}

/// Arcseconds in the unit of the sensor's errors; none where they are no angle.
fn of_arcsec(arcsec: f64, sensor: &Sensor) -> Option<f64> {
    let unit = match sensor {
        Sensor::EddyCurrentPair { .. } => return Some(arcsec),
        Sensor::Direct { revolution: Some(turn), .. } => Unit::part_of_turn(*turn),
        Sensor::Direct { unit, .. } => Unit::named(unit)?,
    };
    Unit::named("arcsec")?.into(unit).map(|(factor, _)| factor * arcsec)
}

const KINDS: &str = "\"direct\" or \"eddy-current-pair\"";

/// A parsed file and its name.
struct Reader<'a> {
    file: &'a str,
    table: &'a Table,
}

impl Reader<'_> {
    fn check_keys(&self) -> Result<(), KeyError> {
        let unknown = |key: &str, known: &[&str]| {
            let name = key.rsplit('.').next().unwrap_or(key);
            let expected = format!("one of {}", quoted(known));
            KeyError::unknown(self.file, name, known, format!("unknown key `{key}`"), expected)
        };
        for (section, content) in self.table {
            let Some((_, keys)) = KEYS.iter().find(|(name, _)| name == section) else {
                return Err(unknown(section, &KEYS.map(|(name, _)| name)));
            };
            let Value::Table(content) = content else {
                return Err(self.wrong(section, content, "a table of keys"));
            };
            if let Some(key) = content.keys().find(|key| !keys.contains(&key.as_str())) {
                return Err(unknown(&format!("{section}.{key}"), keys));
            }
        }
        Ok(())
    }

    fn get(&self, key: &str) -> Option<&Value> {
        let (section, key) = key.split_once('.')?;
        self.table.get(section)?.get(key)
    }

    fn wrong(&self, key: &str, found: &Value, expected: &'static str) -> KeyError {
        let file = self.file.to_string();
        KeyError::Value { file, key: key.to_string(), found: found.to_string(), expected }
    }

    fn positive(&self, key: &'static str, meaning: &'static str) -> Result<f64, KeyError> {
        let value = match self.get(key) {
            None => {
                return Err(KeyError::MissingKey { file: self.file.to_string(), key, expected: meaning });
            }
            Some(Value::Float(value)) => *value,
            Some(Value::Integer(value)) => *value as f64,
            Some(other) => return Err(self.wrong(key, other, "a number")),
        };
        if !(value.is_finite() && value > 0.0) {
            Err(self.wrong(key, &Value::Float(value), "a finite number above zero"))
        } else if crate::limits::scale(value).is_err() {
            Err(KeyError::Value {
                file: self.file.to_string(),
                key: key.to_string(),
                found: crate::faults::shown(value),
                expected: "a number that a sensor can have, 1e-18 to 1e18",
            })
        } else {
            Ok(value)
        }
    }

    fn optional(&self, key: &'static str, meaning: &'static str) -> Result<Option<f64>, KeyError> {
        self.get(key).map(|_| self.positive(key, meaning)).transpose()
    }

    /// What is stated of the reference: in arcseconds, or of a direct sensor in its own unit.
    fn reference(&self, sensor: &Sensor) -> Result<Reference, KeyError> {
        let stated = |in_arcsec, in_unit| -> Result<Option<f64>, KeyError> {
            let arcsec = self.optional(in_arcsec, "a number of arcsec")?;
            match (self.get(in_unit), sensor) {
                (None, _) => Ok(arcsec.and_then(|arcsec| of_arcsec(arcsec, sensor))),
                (Some(_), Sensor::Direct { .. }) if arcsec.is_none() => {
                    self.optional(in_unit, "a number in the sensor's unit")
                }
                (Some(found), Sensor::Direct { .. }) => {
                    Err(self.wrong(in_unit, found, "this key or the one that ends in `_arcsec`, not both"))
                }
                (Some(found), Sensor::EddyCurrentPair { .. }) => {
                    Err(self.wrong(in_unit, found, "the key that ends in `_arcsec` for a pair of probes"))
                }
            }
        };
        Ok(Reference {
            accuracy: stated("reference.accuracy_arcsec", "reference.accuracy")?,
            coverage_factor: self.optional("reference.coverage_factor", "the factor k of a certificate")?,
            repeatability: stated("reference.repeatability_arcsec", "reference.repeatability")?,
        })
    }

    /// The unit reaches column names and generated identifiers, so that it has to be one itself.
    fn unit(&self) -> Result<String, KeyError> {
        match self.get("sensor.unit") {
            None => Err(KeyError::MissingKey {
                file: self.file.to_string(),
                key: "sensor.unit",
                expected: "the unit of `measured` and `reference`, for example \"mm\"",
            }),
            Some(Value::String(unit)) if is_identifier(unit) => Ok(unit.clone()),
            Some(other) => Err(self.wrong(
                "sensor.unit",
                other,
                "letters, digits and underscores, a letter first (\"mm\", \"deg\", \"um\"): it becomes part of names",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated(sensor: &str, reference: &str) -> Result<Reference, String> {
        let text = format!("{sensor}\n[reference]\n{reference}\n");
        Mirror::parse("mirror.toml", &text).map(|mirror| mirror.reference).map_err(|e| e.to_string())
    }

    const ENCODER: &str = "[sensor]\nkind = \"direct\"\nunit = \"counts\"\nrevolution = 3600.0";
    const PAIR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3";

    #[test]
    fn the_reference_is_stated_in_the_unit_of_the_errors() {
        let accuracy = |sensor, reference| stated(sensor, reference).unwrap().accuracy;
        assert_eq!(accuracy(PAIR, "accuracy_arcsec = 1.5"), Some(1.5));
        assert_eq!(accuracy(ENCODER, "accuracy = 0.25"), Some(0.25));
        // 36″ are a hundredth of a degree, a tenth of these counts.
        approx::assert_relative_eq!(accuracy(ENCODER, "accuracy_arcsec = 36").unwrap(), 0.1);
        let degrees = "[sensor]\nkind = \"direct\"\nunit = \"deg\"";
        approx::assert_relative_eq!(accuracy(degrees, "accuracy_arcsec = 36").unwrap(), 0.01);
        let length = "[sensor]\nkind = \"direct\"\nunit = \"mm\"";
        assert_eq!(accuracy(length, "accuracy_arcsec = 36"), None);
        let certificate =
            stated(length, "accuracy = 2e-4\ncoverage_factor = 2\nrepeatability = 5e-5").unwrap();
        assert_eq!((certificate.coverage_factor, certificate.repeatability), (Some(2.0), Some(5e-5)));
    }

    #[test]
    fn a_reference_that_is_stated_twice_or_in_no_unit_is_refused() {
        let twice = stated(ENCODER, "accuracy = 0.1\naccuracy_arcsec = 36").unwrap_err();
        assert!(twice.contains("not both"), "{twice}");
        let pair = stated(PAIR, "accuracy = 0.1").unwrap_err();
        assert!(pair.contains("`_arcsec`"), "{pair}");
        assert!(stated(PAIR, "repeatability_arcsec = -1").is_err());
        let unknown = stated(PAIR, "accuracy_arcsecs = 1").unwrap_err();
        assert!(unknown.contains("did you mean `accuracy_arcsec`?"), "{unknown}");
    }
}
