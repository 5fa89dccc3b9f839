//! A plant that is stated in equations (`kind = "equations"`): inputs, states, the rate of each state, one output, and
//! parameters. Here is what stands in the file; the crate `motion` reads the expressions and runs them.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use physics::{ExpressionError, Interval, Names, Parameter, Sentence, Unit};
use serde::de::Deserializer;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::Hold;
use crate::keys::{self, KeyError};

/// Values by name, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Named<V>(pub Vec<(String, V)>);

impl<V> Default for Named<V> {
    fn default() -> Self {
        Named(Vec::new())
    }
}

impl<V> Named<V> {
    /// The names, in their order.
    pub fn names(&self) -> Vec<&str> {
        self.0.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<&V> {
        self.0.iter().find(|(own, _)| own == name).map(|(_, value)| value)
    }
}

impl<'de, V: Deserialize<'de>> Deserialize<'de> for Named<V> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut all: Vec<(Spanned<String>, V)> =
            BTreeMap::<Spanned<String>, V>::deserialize(deserializer)?.into_iter().collect();
        all.sort_by_key(|(name, _)| name.span().start);
        Ok(Named(all.into_iter().map(|(name, value)| (name.into_inner(), value)).collect()))
    }
}

/// The table `[plant]` of a plant in equations, and the effects in it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Equations {
    /// Unit of every input; the first is the column `drive` (or `drive_1`), and so on; one for which there is no further
    /// drive is the column of its own name.
    pub inputs: Named<String>,
    /// The states.
    pub states: Named<State>,
    /// The output, which is the column `position`: its name and the expression of it.
    pub output: Named<String>,
    /// How the inputs run between their samples; none where the data choose.
    pub sampling: Option<Hold>,
    /// The rate of every state, per second.
    pub equations: Named<String>,
    /// The parameters.
    pub parameters: Named<PlantParameter>,
    /// What was found beyond these equations.
    pub effects: Vec<EffectText>,
}

/// A state.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Its unit.
    pub unit: String,
    /// What it is at the first row.
    pub start: StateStart,
}

/// What a state is at the first row.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum StateStart {
    /// A number in its unit.
    At(f64),
    /// What fits the recording best.
    Fit(Fit),
}

/// The word `"fit"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fit {
    /// `"fit"`
    Fit,
}

/// A parameter of an equation: a value alone is fixed, one with a range is fitted from there, a unit alone belongs to a
/// mere factor of an effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantParameter {
    /// Its unit.
    pub unit: String,
    /// Its value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The smallest value it can have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// The largest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// What `from` and `to` are parts of; numbers in the unit where that is not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<Part>,
    /// From how many places of its range a search starts, where that is not the usual number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts: Option<usize>,
}

/// What the range of an effect's parameter can be a part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// The largest recorded position, in magnitude.
    Position,
    /// The usual speed of the recorded position.
    Speed,
    /// The largest recorded drive, in magnitude.
    Drive,
    /// The time from row to row.
    Step,
    /// The time of the longest run.
    Duration,
}

/// An effect in motion, as it is declared: what it adds to equations, inputs or the output.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct EffectText {
    /// Its id.
    pub id: String,
    /// Its name for a reader.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Where the physics is described.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Ids of the effects that it is most easily taken for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub confused_with: Vec<String>,
    /// What tells it from them.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub experiment: String,
    /// What physics a form without a name may be, as suggestions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<String>,
    /// What it adds to the rate of a state, by the state's name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub equation: BTreeMap<String, String>,
    /// What it adds to an input.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub input: BTreeMap<String, String>,
    /// What it adds to the output.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub output: BTreeMap<String, String>,
    /// What it adds to the acceleration of a second-order plant.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub acceleration: String,
    /// What it adds to the drive of a second-order plant.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub drive: String,
    /// What it adds to the reading of a second-order plant.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reading: String,
    /// States of its own, which begin at zero: the rate of each, per second.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub states: BTreeMap<String, String>,
    /// Every further key is a parameter.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, PlantParameter>,
}

impl EffectText {
    /// Its keys as they stand in a file, one in a line.
    pub fn to_toml(&self) -> String {
        // Only maps with keys that are no strings cannot be written; there are none.
        let table = toml::Table::try_from(self).unwrap_or_default();
        table.iter().map(|(key, value)| format!("{key} = {value}\n")).collect()
    }
}

/// Reads the file of effects in motion at `path`.
///
/// # Errors
/// [`KeyError`] where it cannot be read, or as [`declared`].
pub fn read_declared(path: &Path) -> Result<Vec<EffectText>, KeyError> {
    keys::read(path, "file of effects (TOML)", &["effect"], declared)
}

/// Reads a file of effects in motion, `[[effect]]`; `file` is its name in messages.
///
/// # Errors
/// [`KeyError`] with the line.
pub fn declared(file: &str, text: &str) -> Result<Vec<EffectText>, KeyError> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Effects {
        effect: Vec<EffectText>,
    }
    let read: Result<Effects, _> = toml::from_str(text);
    read.map(|effects| effects.effect).map_err(|error| KeyError::syntax(file, text, &error))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    plant: Table,
    #[serde(default)]
    effects: Vec<EffectText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    #[serde(rename = "kind")]
    _kind: super::Kind,
    #[serde(default)]
    inputs: Named<String>,
    states: Named<State>,
    output: Named<String>,
    sampling: Option<Sampling>,
    equations: Named<String>,
    #[serde(default)]
    parameters: Named<PlantParameter>,
}

/// How inputs run between their samples, in the words of a plant in equations.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Sampling {
    Held,
    Straight,
    BandLimited,
}

const SAMPLINGS: [(Sampling, Hold, &str); 3] = [
    (Sampling::Held, Hold::ZeroOrder, "held"),
    (Sampling::Straight, Hold::FirstOrder, "straight"),
    (Sampling::BandLimited, Hold::BandLimited, "band-limited"),
];

impl Equations {
    /// Reads the text of a plant in equations.
    ///
    /// # Errors
    /// What is no TOML, or a key that is missing, unknown or of another kind, with its place.
    pub fn parse(text: &str) -> Result<Equations, toml::de::Error> {
        let File { plant, effects } = toml::from_str(text)?;
        let Table { inputs, states, output, sampling, equations, parameters, .. } = plant;
        let hold = |sampling: Sampling| SAMPLINGS[sampling as usize].1;
        let sampling = sampling.map(hold);
        Ok(Equations { inputs, states, output, sampling, equations, parameters, effects })
    }

    /// The file's text; [`Equations::parse`] gives the same plant back.
    pub fn to_toml(&self) -> String {
        let quoted = |text: &String| toml::Value::String(text.clone()).to_string();
        let mut out = String::from("[plant]\nkind = \"equations\"\n");
        // Writing to a string does not fail.
        let units = self.inputs.0.iter().map(|(name, unit)| format!("{name} = {}", quoted(unit)));
        let _ = writeln!(out, "inputs = {{ {} }}", units.collect::<Vec<_>>().join(", "));
        let state = |(name, state): &(String, State)| {
            let start = match state.start {
                StateStart::At(value) => toml::Value::Float(value).to_string(),
                StateStart::Fit(_) => "\"fit\"".into(),
            };
            format!("{name} = {{ unit = {}, start = {start} }}", quoted(&state.unit))
        };
        let states: Vec<String> = self.states.0.iter().map(state).collect();
        let _ = writeln!(out, "states = {{ {} }}", states.join(", "));
        for (name, expression) in &self.output.0 {
            let _ = writeln!(out, "output = {{ {name} = {} }}", quoted(expression));
        }
        if let Some((.., word)) = SAMPLINGS.iter().find(|s| Some(s.1) == self.sampling) {
            let _ = writeln!(out, "sampling = \"{word}\"");
        }
        out.push_str("\n[plant.equations]\n");
        for (name, expression) in &self.equations.0 {
            let _ = writeln!(out, "{name} = {}", quoted(expression));
        }
        out.push_str("\n[plant.parameters]\n");
        for (name, PlantParameter { unit, value, from, to, .. }) in &self.parameters.0 {
            let numbers = [("value", value), ("from", from), ("to", to)];
            let given = numbers.iter().filter_map(|(key, number)| {
                number.map(|number| format!(", {key} = {}", toml::Value::Float(number)))
            });
            let _ = writeln!(out, "{name} = {{ unit = {}{} }}", quoted(unit), given.collect::<String>());
        }
        for effect in &self.effects {
            let _ = write!(out, "\n[[effects]]\n{}", effect.to_toml());
        }
        out
    }

    /// Refuses what no plant can be, before its expressions are read: how many outputs it has, which states have an
    /// equation, which names stand for two things.
    ///
    /// # Errors
    /// The key, what was found there and what was expected.
    pub fn check(&self) -> Result<(), (String, String, &'static str)> {
        let states = self.states.names();
        if states.is_empty() {
            return Err(("plant.states".into(), "none".into(), "one state or more"));
        }
        if self.output.0.len() != 1 {
            let found = format!("{} outputs", self.output.0.len());
            return Err(("plant.output".into(), found, "one, as in { y = \"x\" }"));
        }
        if let Some(state) = states.iter().find(|state| self.equations.get(state).is_none()) {
            let key = format!("plant.equations.{state}");
            return Err((key, "missing".into(), "the rate of the state per second"));
        }
        if let Some(name) = self.equations.names().into_iter().find(|name| !states.contains(name)) {
            return Err((format!("plant.equations.{name}"), "an equation".into(), "the name of a state"));
        }
        let mut all = vec!["t"];
        all.extend(self.inputs.names());
        all.extend(&states);
        all.extend(self.parameters.names());
        for (k, name) in all.iter().enumerate() {
            if all[..k].contains(name) {
                return Err((
                    format!("plant: `{name}`"),
                    "two meanings".into(),
                    "a name of its own for each",
                ));
            }
        }
        Ok(())
    }
}

impl Equations {
    /// The unit of every state and input, and of the time `t`.
    ///
    /// # Errors
    /// The key of what is no unit.
    pub fn units(&self) -> Result<BTreeMap<String, Unit>, (String, String, &'static str)> {
        let states = self.states.0.iter().map(|(name, state)| (name, &state.unit));
        let inputs = self.inputs.0.iter().map(|(name, unit)| (name, unit));
        let mut units = BTreeMap::from([("t".to_string(), Unit::of_column("t_s"))]);
        for (name, unit) in states.chain(inputs) {
            let wrong = |_| (format!("plant: the unit of `{name}`"), unit.clone(), "a unit such as rad/s");
            units.insert(name.clone(), Unit::parse(unit).map_err(wrong)?);
        }
        Ok(units)
    }

    /// The unit of the output.
    ///
    /// # Errors
    /// The key of what has no unit.
    pub fn output_unit(&self) -> Result<String, (String, String, &'static str)> {
        let units = self.units()?;
        let (name, text) = &self.output.0[0];
        if let Some(state) = self.states.get(text) {
            return Ok(state.unit.clone());
        }
        let parameters: Vec<Parameter> =
            self.parameters.0.iter().filter_map(PlantParameter::checked).collect();
        let column = |name: &str| units.get(name).cloned();
        let held = |expression: &physics::Expression, parameter: &Parameter| {
            expression.names().contains(&parameter.name.as_str())
        };
        let unit = physics::parse(text).and_then(|expression| {
            let parameters: Vec<Parameter> =
                parameters.into_iter().filter(|parameter| held(&expression, parameter)).collect();
            let names = Names { column: &column, known: &[], parameters: &parameters };
            Ok(Sentence::read(text, None, &names)?.unit)
        });
        let wrong = |error: ExpressionError| {
            (format!("plant.output.{name}"), error.to_string(), "an expression of states and inputs")
        };
        Ok(unit.map_err(wrong)?.to_string())
    }
}

impl PlantParameter {
    /// The parameter of a name as expressions have it; none where its unit is none.
    pub fn checked((name, parameter): &(String, PlantParameter)) -> Option<Parameter> {
        let range = match (parameter.from, parameter.to, parameter.value) {
            (Some(from), Some(to), _) => Some(Interval { from, to }),
            (.., Some(value)) => Some(Interval { from: value, to: value }),
            _ => None,
        };
        Some(Parameter { name: name.clone(), unit: Unit::parse(&parameter.unit).ok()?, range })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TANKS: &str = r#"
[plant]
kind = "equations"
inputs = { w = "V", u = "V" }
states = { h1 = { unit = "V", start = "fit" }, h2 = { unit = "V", start = 0.5 } }
output = { y = "h2" }
sampling = "held"
[plant.equations]
h1 = "-k1 * sqrt(h1) + k4 * u"
h2 = "k1 * sqrt(h1) + w * k4"
[plant.parameters]
k1 = { unit = "V^0.5/s", from = 0.001, to = 1.0 }
k4 = { unit = "1/s", value = 0.25 }
[[effects]]
id = "overflow"
equation.h1 = "-k * hinge(h1, 10)"
k = { unit = "1/s", value = 3 }
"#;

    #[test]
    fn a_plant_in_equations_reads_back() {
        let plant = Equations::parse(TANKS).unwrap();
        plant.check().unwrap();
        assert_eq!(plant.inputs.names(), ["w", "u"], "in the order of the file");
        assert_eq!(plant.sampling, Some(Hold::ZeroOrder));
        assert_eq!(plant.effects[0].equation["h1"], "-k * hinge(h1, 10)");
        assert_eq!(Equations::parse(&plant.to_toml()).unwrap(), plant);
    }

    #[test]
    fn what_is_missing_is_named() {
        let without = TANKS.replace("h2 = \"k1", "h3 = \"k1");
        let (key, ..) = Equations::parse(&without).unwrap().check().unwrap_err();
        assert_eq!(key, "plant.equations.h2");
        let twice = TANKS.replace("k4 = { unit", "u = { unit");
        assert_eq!(Equations::parse(&twice).unwrap().check().unwrap_err().0, "plant: `u`");
    }
}
