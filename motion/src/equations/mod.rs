//! A plant that is stated in equations: read, checked for names and units, compiled, and run with or without
//! derivatives. Nothing here knows how it is fitted.

mod course;
mod delays;
mod effect;
mod events;
mod input;
mod observer;
mod plays;
mod reach;
mod rule;
mod run;
mod system;

use fitter::plant::equations::{Equations, Named, StateStart};
use fitter::plant::{Hold, PlantFile};
use physics::{ExpressionError, Names, Parameter, Sentence, Unit};

pub use course::{Course, MOST_SUBSTEPS, Stopped};
pub use effect::{Added, MotionEffect, Target};
pub use input::{Input, Piece};
pub use observer::Observer;
pub use system::System;

fitter::errors! {
    /// What is wrong with a plant in equations, or with an effect in it.
    #[derive(Debug, Clone, PartialEq)]
    pub enum EquationsError {
        Expression { file: String, key: String, error: Box<ExpressionError> } => at(file) says("{key}: {error}");
        Key { file: String, key: String, what: String } => at(file) says("{key}: {what}");
    }
}

/// A plant in equations whose names and units are right.
#[derive(Debug, Clone)]
pub struct Plant {
    /// The file's name in messages.
    pub file: String,
    /// States with their units, in the order of the file.
    pub states: Vec<(String, Unit)>,
    /// Where each state begins; none where that is fitted.
    pub starts: Vec<Option<f64>>,
    /// Inputs with their units.
    pub inputs: Vec<(String, Unit)>,
    /// How the inputs run between their samples; none where the data choose.
    pub sampling: Option<Hold>,
    /// Name of the output, and what it is.
    pub output: (String, Sentence),
    /// The rate of each state, with the numbers of its parameters.
    pub rates: Vec<(Sentence, Vec<usize>)>,
    /// The numbers of the output's parameters.
    pub of_output: Vec<usize>,
    /// All parameters; the range of a fixed one is a point.
    pub parameters: Vec<Parameter>,
    /// Their values, as far as the file gives them.
    pub values: Vec<Option<f64>>,
    /// Effects that the file holds, with the values of their parameters.
    pub effects: Vec<(MotionEffect, Vec<f64>)>,
}

impl Plant {
    /// Reads the expressions of a plant file; none where it is of another kind.
    ///
    /// # Errors
    /// [`EquationsError`] with the key and the place in its expression.
    pub fn of(file: &str, plant: &PlantFile) -> Option<Result<Plant, EquationsError>> {
        plant.equations.as_ref().map(|equations| Plant::read(file, equations))
    }

    fn read(file: &str, equations: &Equations) -> Result<Plant, EquationsError> {
        let key = |key: String, what: String| EquationsError::Key { file: file.into(), key, what };
        let units =
            equations.units().map_err(|(name, found, _)| key(name, format!("`{found}` is no unit")))?;
        let with_unit = |name: &String| (name.clone(), units.get(name).cloned().unwrap_or_else(Unit::one));
        let states: Vec<_> = equations.states.0.iter().map(|(name, _)| with_unit(name)).collect();
        let inputs: Vec<_> = equations.inputs.0.iter().map(|(name, _)| with_unit(name)).collect();
        let starts = equations.states.0.iter().map(|(_, state)| match state.start {
            StateStart::At(value) => Some(value),
            StateStart::Fit(_) => None,
        });
        let starts = starts.collect();
        let parameters = parameters(file, &equations.parameters)?;
        let column = |name: &str| units.get(name).cloned();
        let known: Vec<&str> = units.keys().map(String::as_str).collect();
        let read =
            |key: String, text: &str, unit: Option<&Unit>| {
                sentence(text, unit, &column, &known, &parameters).map_err(|error| {
                    EquationsError::Expression { file: file.into(), key, error: Box::new(error) }
                })
            };
        let rates = states.iter().map(|(name, unit)| {
            let text = equations.equations.get(name).map_or("0", String::as_str);
            read(format!("`plant.equations.{name}`"), text, Some(&per_second(unit)))
        });
        let rates = rates.collect::<Result<Vec<_>, _>>()?;
        let (name, text) = &equations.output.0[0];
        let (output, of_output) = read(format!("`plant.output.{name}`"), text, None)?;
        let used = |k: &usize| rates.iter().any(|(_, of)| of.contains(k)) || of_output.contains(k);
        if let Some(idle) = (0..parameters.len()).find(|k| !used(k)) {
            let name = format!("`plant.parameters.{}`", parameters[idle].name);
            return Err(key(name, "no equation holds it: use it or drop it".into()));
        }
        let values = equations.parameters.0.iter().map(|(_, parameter)| parameter.value).collect();
        let (file, output) = (file.to_string(), (name.clone(), output));
        let mut plant = Plant {
            file,
            states,
            starts,
            inputs,
            sampling: equations.sampling,
            output,
            rates,
            of_output,
            parameters,
            values,
            effects: Vec::new(),
        };
        plant.effects = equations.effects.iter().map(|text| plant.held(text)).collect::<Result<_, _>>()?;
        Ok(plant)
    }

    /// The unit of the output.
    pub fn output_unit(&self) -> &Unit {
        &self.output.1.unit
    }

    /// Whether a parameter is one that is fitted.
    pub fn is_free(&self, parameter: usize) -> bool {
        self.parameters[parameter].range.is_none_or(|range| range.from < range.to)
    }
}

/// The unit of a rate.
fn per_second(unit: &Unit) -> Unit {
    Unit::of_column("t_s").power(-1.0).map_or_else(|| unit.clone(), |per| unit.times(&per))
}

/// The parameters of a file, each with a unit, and a range or a value.
fn parameters(
    file: &str,
    named: &Named<fitter::plant::equations::PlantParameter>,
) -> Result<Vec<Parameter>, EquationsError> {
    let checked = |entry: &(String, fitter::plant::equations::PlantParameter)| {
        let (name, parameter) = entry;
        let wrong = |what: String| {
            let key = format!("`plant.parameters.{name}`");
            EquationsError::Key { file: file.into(), key, what }
        };
        let checked = fitter::plant::equations::PlantParameter::checked(entry)
            .ok_or_else(|| wrong(format!("`{}` is no unit, expected one such as 1/s", parameter.unit)))?;
        let Some(range) = checked.range else {
            return Err(wrong("has neither a value nor a range: give `value`, or `from` and `to`".into()));
        };
        if !(range.from.is_finite() && range.to.is_finite() && range.from <= range.to) {
            let (from, to) = (range.from, range.to);
            return Err(wrong(format!("runs from {from} to {to}, expected finite numbers, `to` the larger")));
        }
        match parameter.value {
            Some(value) if !(range.from..=range.to).contains(&value) => {
                Err(wrong(format!("is {value}, expected it between {} and {}", range.from, range.to)))
            }
            _ => Ok(checked),
        }
    };
    named.0.iter().map(checked).collect()
}

/// A sentence with those of the parameters that are in it, and their numbers; in its own unit where none is given.
fn sentence(
    text: &str,
    unit: Option<&Unit>,
    column: &dyn Fn(&str) -> Option<Unit>,
    known: &[&str],
    parameters: &[Parameter],
) -> Result<(Sentence, Vec<usize>), ExpressionError> {
    let expression = physics::parse(text)?;
    let names = expression.names();
    let held = |k: &usize| names.contains(&parameters[*k].name.as_str());
    let numbers: Vec<usize> = (0..parameters.len()).filter(held).collect();
    let own: Vec<Parameter> = numbers.iter().map(|k| parameters[*k].clone()).collect();
    let names = Names { column, known, parameters: &own };
    Ok((Sentence::read(text, unit, &names)?, numbers))
}

#[cfg(test)]
mod tests;
