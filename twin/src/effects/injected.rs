//! An effect that is to be hidden in a device: its id and its parameters.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::catalogue::{ALL, find};
use super::{EffectError, Known, Mechanism, Specification, Values};
use crate::device::Device;

/// An effect with its parameters, named as in the table of effects.
///
/// Read from text as `id:parameter=value,parameter=value`:
///
/// ```
/// let effect: twin::Injected = "mount_step:step_arcsec=3,time_s=400".parse().unwrap();
/// assert_eq!(effect.parameters["time_s"], 400.0);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Injected {
    /// The id.
    pub id: String,
    /// The parameters by name; what is not given has its default.
    pub parameters: BTreeMap<String, f64>,
}

fn ids() -> String {
    ALL.iter().map(|s| s.id).collect::<Vec<_>>().join(", ")
}

impl Injected {
    /// An effect from its id and named values.
    pub fn new<const N: usize>(id: &str, parameters: [(&str, f64); N]) -> Self {
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
        Self { id: id.to_owned(), parameters }
    }

    /// The same effect, `factor` times as strong. An effect whose strength is not given stays as it is.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        if let Some(name) = find(&self.id).and_then(Specification::strength).map(|p| p.name)
            && let Some(value) = scaled.parameters.get_mut(name)
        {
            *value *= factor;
        }
        scaled
    }

    /// Whether it shows only where the mirror is read while it moves.
    pub fn needs_motion(&self) -> bool {
        find(&self.id).is_some_and(|s| s.depends_on.contains(&"velocity"))
    }

    /// Makes the mechanism for `device`.
    pub fn build(&self, device: &Device) -> Result<Box<dyn Mechanism>, EffectError> {
        let id = || self.id.clone();
        let specification = find(&self.id).ok_or_else(|| EffectError::Id { id: id(), expected: ids() })?;
        let known: Vec<Known> = specification
            .parameters
            .iter()
            .map(|p| Known { name: p.name, unit: p.unit, default: p.default, range: p.range })
            .collect();
        let values = Values::check(&self.id, &known, &self.parameters)?;
        (specification.build)(&values, device).map_err(|reason| EffectError::Refused { id: id(), reason })
    }
}

impl FromStr for Injected {
    type Err = EffectError;

    fn from_str(text: &str) -> Result<Self, EffectError> {
        let wrong = || EffectError::Text { text: text.to_owned() };
        let (id, rest) = text.split_once(':').ok_or_else(wrong)?;
        let mut parameters = BTreeMap::new();
        for part in rest.split(',').filter(|part| !part.trim().is_empty()) {
            let (name, value) = part.split_once('=').ok_or_else(wrong)?;
            let (name, value) = (name.trim().to_owned(), value.trim());
            let number = value.parse().map_err(|_| EffectError::Number {
                id: id.to_owned(),
                parameter: name.clone(),
                value: value.to_owned(),
            })?;
            if parameters.insert(name, number).is_some() {
                return Err(wrong());
            }
        }
        Ok(Self { id: id.trim().to_owned(), parameters })
    }
}
