//! Equations and effects compiled to one tape.

use physics::ExpressionError;
use physics::tape::{Lag, Place, Tape};

use super::effect::{MotionEffect, Target};
use super::{EquationsError, Plant};

/// A plant with effects, ready to be run: its parameters are those of the plant, then those of each effect.
#[derive(Clone)]
pub struct System {
    pub(super) tape: Tape,
    /// Names of the states, for messages.
    pub(super) names: Vec<String>,
    /// Register of the rate of every state of the plant.
    pub(super) rates: Vec<usize>,
    /// Register of the output.
    pub(super) output: usize,
    /// Register of the output without effects.
    pub(super) read: usize,
    pub(super) inputs: usize,
}

impl System {
    /// A plant with effects, in whose order offsets and limits of an input or the output follow each other.
    ///
    /// # Errors
    /// [`EquationsError::Expression`] where no equation of motion can hold an operator.
    pub fn new(plant: &Plant, effects: &[&MotionEffect]) -> Result<System, EquationsError> {
        let mut tape = Tape::new(plant.states.len());
        let key = |key: String| {
            let file = plant.file.clone();
            move |error: ExpressionError| EquationsError::Expression { file, key, error: Box::new(error) }
        };
        tape.name("t", Place::Time);
        for (k, (name, _)) in plant.states.iter().enumerate() {
            tape.name(name, Place::State(k));
        }
        for (k, (name, _)) in plant.inputs.iter().enumerate() {
            tape.name(name, Place::Input(k));
        }
        let mut first = plant.parameters.len();
        let numbered: Vec<(&MotionEffect, usize)> = effects
            .iter()
            .map(|effect| {
                let own = first;
                first += effect.parameters.len();
                (*effect, own)
            })
            .collect();
        // All that acts in one place, one after the other.
        let add = |tape: &mut Tape, to: Target, mut register: usize, name: Option<&str>| {
            for (effect, first) in &numbered {
                for added in effect.adds.iter().filter(|added| added.to == to) {
                    let numbers: Vec<usize> = added.parameters.iter().map(|k| first + k).collect();
                    let more = tape
                        .add(&added.sentence, &numbers)
                        .map_err(key(format!("effect `{}`", effect.text.id)))?;
                    register = tape.sum(register, more);
                    if let Some(name) = name {
                        tape.name(name, Place::Register(register));
                    }
                }
            }
            Ok(register)
        };
        for (k, (name, _)) in plant.inputs.iter().enumerate() {
            let register = tape.value_of(Place::Input(k));
            add(&mut tape, Target::Input(k), register, Some(name))?;
        }
        let (name, sentence) = &plant.output;
        let read = tape.add(sentence, &plant.of_output).map_err(key(format!("`plant.output.{name}`")))?;
        tape.name(name, Place::Register(read));
        let mut rates = Vec::with_capacity(plant.states.len());
        for (k, ((sentence, numbers), (state, _))) in plant.rates.iter().zip(&plant.states).enumerate() {
            let register = tape.add(sentence, numbers).map_err(key(format!("`plant.equations.{state}`")))?;
            rates.push(add(&mut tape, Target::Rate(k), register, None)?);
        }
        let output = add(&mut tape, Target::Output, read, Some(name))?;
        let mut names: Vec<String> = plant.states.iter().map(|(name, _)| name.clone()).collect();
        names.extend(tape.lags().iter().map(|_| "a lag".to_string()));
        Ok(System { tape, names, rates, output, read, inputs: plant.inputs.len() })
    }

    /// The lags, whose states follow those of the plant.
    pub(super) fn lags(&self) -> &[Lag] {
        self.tape.lags()
    }

    /// Number of states, those of lags included.
    pub fn states(&self) -> usize {
        self.names.len()
    }
}
