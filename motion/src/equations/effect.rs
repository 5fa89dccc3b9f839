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
    /// An input, by number.
    Input(usize),
    /// The output.
    Output,
}

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
            Target::Input(k) => format!("{} += {}", plant.inputs[k].0, added.sentence.text),
            Target::Output => format!("{} += {}", plant.output.0, added.sentence.text),
        };
        self.adds.iter().map(one).collect::<Vec<_>>().join("; ")
    }
}

impl Plant {
    /// Reads a declared effect.
    ///
    /// # Errors
    /// [`EquationsError`]: what it acts on is not in the plant, a name or a unit does not fit, a parameter without a
    /// range is no factor, or it adds nothing.
    pub fn effect(&self, file: &str, text: &EffectText) -> Result<MotionEffect, EquationsError> {
        let key = |key: &str| format!("effect `{}`, `{key}`", text.id);
        let wrong = |at: &str, what: String| EquationsError::Key { file: file.into(), key: key(at), what };
        if !physics::is_identifier(&text.id) {
            return Err(wrong("id", "has letters other than a to z, digits and `_`: give another".into()));
        }
        let parameters = (text.parameters.iter())
            .map(|(name, parameter)| self.own_parameter(name, parameter).map_err(|what| wrong(name, what)))
            .collect::<Result<Vec<_>, _>>()?;
        let place = |all: &[(String, Unit)], name: &str, table: &str| {
            let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
            let found = names.iter().position(|own| *own == name);
            found.ok_or_else(|| {
                let names = if names.is_empty() { "none".into() } else { names.join(", ") };
                wrong(
                    &format!("{table}.{name}"),
                    format!("the plant has no such name, expected one of: {names}"),
                )
            })
        };
        let mut adds: Vec<(Target, Unit, String, &String)> = Vec::new();
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
            return Err(wrong(
                "equation",
                "adds nothing: give equation.<state>, input.<input> or output.<output>".into(),
            ));
        }
        let units = self.units();
        let column = |name: &str| units.get(name).cloned();
        let known: Vec<&str> = units.keys().map(String::as_str).collect();
        let read = |(to, unit, at, added): (Target, Unit, String, &String)| {
            let read = sentence(added, Some(&unit), &column, &known, &parameters);
            let error = |error| EquationsError::Expression {
                file: file.into(),
                key: key(&at),
                error: Box::new(error),
            };
            read.map(|(sentence, parameters)| Added { to, sentence, parameters }).map_err(error)
        };
        let adds = adds.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let used = |k: &usize| adds.iter().any(|added| added.parameters.contains(k));
        if let Some(idle) = (0..parameters.len()).find(|k| !used(k)) {
            return Err(wrong(&parameters[idle].name, "is in no expression: use it or drop it".into()));
        }
        Ok(MotionEffect { text: text.clone(), adds, parameters })
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
