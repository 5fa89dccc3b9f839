//! Effects in a plant of equations: what each adds to the rate of a state, to an input, or to the output.

use std::collections::BTreeMap;

use fitter::plant::equations::{EffectText, PlantParameter};
use physics::{Interval, Parameter, Sentence, Unit};

use super::{EquationsError, Plant, per_second, sentence};

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// The rate of a state, by number.
    Rate(usize),
    /// The rate of a state of the effect's own, by number.
    Own(usize),
    /// An input, by number.
    Input(usize),
    /// The output.
    Output,
}

/// Most states of an effect's own.
const MOST_OWN: usize = 2;

/// What an effect adds somewhere.
#[derive(Debug, Clone)]
pub struct Added {
    /// Where.
    pub to: Target,
    /// What.
    pub sentence: Sentence,
    /// Which of the effect's parameters the sentence holds, in its order.
    pub parameters: Vec<usize>,
}

/// An effect whose names and units are right.
#[derive(Debug, Clone)]
pub struct MotionEffect {
    /// As it was declared.
    pub text: EffectText,
    /// States of its own, with their units; they begin at zero.
    pub states: Vec<(String, Unit)>,
    /// What it adds.
    pub adds: Vec<Added>,
    /// Its parameters; those without a range are factors.
    pub parameters: Vec<Parameter>,
}

impl MotionEffect {
    /// The name for a reader.
    pub fn title(&self) -> String {
        if self.text.title.is_empty() { self.text.id.replace('_', " ") } else { self.text.title.clone() }
    }

    /// What it adds, for a reader: `v' += -F * sign(v)`.
    pub fn formula(&self, plant: &Plant) -> String {
        let one = |added: &Added| match added.to {
            Target::Rate(k) => format!("{}' += {}", plant.states[k].0, added.sentence.text),
            Target::Own(k) => format!("{}' = {}", self.states[k].0, added.sentence.text),
            Target::Input(k) => format!("{} += {}", plant.inputs[k].0, added.sentence.text),
            Target::Output => format!("{} += {}", plant.output.0, added.sentence.text),
        };
        self.adds.iter().map(one).collect::<Vec<_>>().join("; ")
    }
}

/// Messages about a declared effect.
trait Refused {
    fn key(&self, key: &str) -> String;
    fn wrong(&self, file: &str, at: &str, what: String) -> EquationsError;
}

impl Refused for EffectText {
    fn key(&self, key: &str) -> String {
        format!("effect `{}`, `{key}`", self.id)
    }

    fn wrong(&self, file: &str, at: &str, what: String) -> EquationsError {
        EquationsError::Key { file: file.into(), key: self.key(at), what }
    }
}

/// What an effect adds, as it is declared: where, in which unit, under which key.
type Declared<'a> = (Target, Unit, String, &'a String);

impl Plant {
    /// Reads a declared effect. The unit of a state of its own is the first with which all that it adds has the right unit,
    /// of those of the plant and 1.
    ///
    /// # Errors
    /// [`EquationsError`]: what it acts on is not in the plant, a name or a unit does not fit, a parameter without a
    /// range is no factor, or it adds nothing.
    pub fn effect(&self, file: &str, text: &EffectText) -> Result<MotionEffect, EquationsError> {
        let wrong = |at: &str, what: String| text.wrong(file, at, what);
        if !physics::is_identifier(&text.id) {
            return Err(wrong("id", "has letters other than a to z, digits and `_`: give another".into()));
        }
        for (key, added) in
            [("acceleration", &text.acceleration), ("drive", &text.drive), ("reading", &text.reading)]
        {
            if !added.is_empty() {
                let what =
                    "is for a second-order plant: give equation.<state>, input.<input> or output.<output>";
                return Err(wrong(key, what.into()));
            }
        }
        let parameters = (text.parameters.iter())
            .map(|(name, parameter)| self.own_parameter(name, parameter).map_err(|what| wrong(name, what)))
            .collect::<Result<Vec<_>, _>>()?;
        let names: Vec<&String> = text.states.keys().collect();
        if names.len() > MOST_OWN {
            return Err(wrong("states", format!("are {}, expected at most {MOST_OWN}", names.len())));
        }
        let taken = |name: &String| self.units().contains_key(name) || text.parameters.contains_key(name);
        if let Some(name) = names.iter().find(|name| taken(name) || !physics::is_identifier(name)) {
            return Err(wrong(&format!("states.{name}"), "has no name of its own: give another".into()));
        }
        let mut units: Vec<Unit> = vec![self.output_unit().clone(), Unit::one()];
        units.extend(self.states.iter().chain(&self.inputs).map(|(_, unit)| unit.clone()));
        let with = |number: usize| {
            let unit = |k: usize| units[number / units.len().pow(k as u32) % units.len()].clone();
            let states = names.iter().enumerate().map(|(k, name)| ((*name).clone(), unit(k))).collect();
            self.with_states(file, text, &parameters, states)
        };
        let all = units.len().pow(names.len() as u32);
        let first = with(0);
        if first.is_ok() { first } else { (1..all).find_map(|number| with(number).ok()).map_or(first, Ok) }
    }

    /// Reads an effect whose own states have these units.
    fn with_states(
        &self,
        file: &str,
        text: &EffectText,
        parameters: &[Parameter],
        states: Vec<(String, Unit)>,
    ) -> Result<MotionEffect, EquationsError> {
        let wrong = |at: &str, what: String| text.wrong(file, at, what);
        let adds = self.declared(file, text, &states)?;
        let mut units = self.units();
        units.extend(states.iter().cloned());
        let column = |name: &str| units.get(name).cloned();
        let known: Vec<&str> = units.keys().map(String::as_str).collect();
        let read = |(to, unit, at, added): Declared| {
            let error = |error| EquationsError::Expression {
                file: file.into(),
                key: text.key(&at),
                error: Box::new(error),
            };
            let (sentence, numbers) =
                sentence(added, Some(&unit), &column, &known, parameters).map_err(error)?;
            let factor = numbers.iter().find(|k| parameters[**k].range.is_none());
            match (to, factor) {
                (Target::Own(_), Some(k)) => {
                    let what = format!("`{}` has no range: give `from` and `to`", parameters[*k].name);
                    Err(wrong(&at, what))
                }
                _ => Ok(Added { to, sentence, parameters: numbers }),
            }
        };
        let adds = adds.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let used = |k: &usize| adds.iter().any(|added| added.parameters.contains(k));
        if let Some(idle) = (0..parameters.len()).find(|k| !used(k)) {
            return Err(wrong(&parameters[idle].name, "is in no expression: use it or drop it".into()));
        }
        Ok(MotionEffect { text: text.clone(), states, adds, parameters: parameters.to_vec() })
    }

    /// What an effect adds, and where.
    fn declared<'a>(
        &self,
        file: &str,
        text: &'a EffectText,
        states: &[(String, Unit)],
    ) -> Result<Vec<Declared<'a>>, EquationsError> {
        let place = |all: &[(String, Unit)], name: &str, table: &str| {
            let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
            let found = names.iter().position(|own| *own == name);
            found.ok_or_else(|| {
                let names = if names.is_empty() { "none".into() } else { names.join(", ") };
                let what = format!("the plant has no such name, expected one of: {names}");
                text.wrong(file, &format!("{table}.{name}"), what)
            })
        };
        let mut adds: Vec<Declared> = Vec::new();
        for (name, added) in &text.equation {
            let k = place(&self.states, name, "equation")?;
            adds.push((Target::Rate(k), per_second(&self.states[k].1), format!("equation.{name}"), added));
        }
        for (name, added) in &text.input {
            let k = place(&self.inputs, name, "input")?;
            adds.push((Target::Input(k), self.inputs[k].1.clone(), format!("input.{name}"), added));
        }
        for (name, added) in &text.output {
            let output = [(self.output.0.clone(), self.output_unit().clone())];
            place(&output, name, "output")?;
            adds.push((Target::Output, self.output_unit().clone(), format!("output.{name}"), added));
        }
        if adds.is_empty() {
            let what = "adds nothing: give equation.<state>, input.<input> or output.<output>; beside a second-order plant \
                        acceleration, drive or reading";
            return Err(text.wrong(file, "equation", what.into()));
        }
        for (k, ((name, unit), added)) in states.iter().zip(text.states.values()).enumerate() {
            adds.push((Target::Own(k), per_second(unit), format!("states.{name}"), added));
        }
        Ok(adds)
    }

    /// Units of all that an effect can read.
    fn units(&self) -> BTreeMap<String, Unit> {
        let mut units = BTreeMap::from([
            ("t".to_string(), Unit::of_column("t_s")),
            (self.output.0.clone(), self.output_unit().clone()),
        ]);
        units.extend(self.inputs.iter().chain(&self.states).cloned());
        units
    }

    /// A parameter of an effect; its name is none of the plant's.
    fn own_parameter(&self, name: &str, parameter: &PlantParameter) -> Result<Parameter, String> {
        if self.units().contains_key(name) {
            return Err("is the name of a state, an input or the output: give another".into());
        }
        let unit = Unit::parse(&parameter.unit)?;
        let range = match (parameter.from, parameter.to) {
            (None, None) => None,
            (Some(from), Some(to)) if from.is_finite() && to.is_finite() && from < to => {
                Some(Interval { from, to })
            }
            _ => return Err("has no proper range: give `from` and `to`, finite, `to` the larger".into()),
        };
        Ok(Parameter { name: name.to_string(), unit, range })
    }

    /// An effect that the plant's file holds, with its values.
    pub(super) fn held(&self, text: &EffectText) -> Result<(MotionEffect, Vec<f64>), EquationsError> {
        let effect = self.effect(&self.file, text)?;
        let value = |(name, parameter): (&String, &PlantParameter)| {
            parameter.value.filter(|value| value.is_finite()).ok_or_else(|| EquationsError::Key {
                file: self.file.clone(),
                key: format!("effect `{}`, `{name}`", text.id),
                what: "has no value: give `value`".into(),
            })
        };
        let values = text.parameters.iter().map(value).collect::<Result<Vec<_>, _>>()?;
        Ok((effect, values))
    }
}
