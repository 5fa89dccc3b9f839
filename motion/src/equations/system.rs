//! Equations and effects compiled to one tape.

use physics::ExpressionError;
use physics::tape::{Place, Row, Tape};

use super::effect::{MotionEffect, Target};
use super::{EquationsError, Plant};

/// A plant with effects, ready to be run: its parameters are those of the plant, then those of each effect.
#[derive(Clone)]
pub struct System {
    pub(super) tape: Tape,
    /// Names of the states, for messages.
    pub(super) names: Vec<String>,
    /// The rate of every state, those of lags last.
    pub(super) rates: Vec<Row>,
    /// Where the lags begin.
    pub(super) starts: Vec<Row>,
    /// The arguments of switches.
    pub(super) arguments: Vec<Row>,
    pub(super) output: Row,
    /// The output without effects.
    pub(super) read: Row,
    pub(super) inputs: usize,
}

impl System {
    /// A plant with effects, in whose order offsets and limits of an input or the output follow each other.
    ///
    /// # Errors
    /// [`EquationsError::Expression`] where no equation of motion can hold an operator.
    pub fn new(plant: &Plant, effects: &[&MotionEffect]) -> Result<System, EquationsError> {
        let own_states: usize = effects.iter().map(|effect| effect.states.len()).sum();
        let mut tape = Tape::new(plant.states.len() + own_states);
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
        // Every effect with the numbers of its first parameter and its first state.
        let (mut first, mut state) = (plant.parameters.len(), plant.states.len());
        let mut numbered: Vec<(&MotionEffect, usize, usize)> = Vec::with_capacity(effects.len());
        for effect in effects {
            numbered.push((effect, first, state));
            (first, state) = (first + effect.parameters.len(), state + effect.states.len());
        }
        // All that acts in one place, one after the other.
        let add = |tape: &mut Tape, to: Target, mut register: usize, name: Option<&str>| {
            for (effect, first, state) in &numbered {
                for (k, (own, _)) in effect.states.iter().enumerate() {
                    tape.name(own, Place::State(state + k));
                }
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
        for (effect, first, state) in &numbered {
            for (k, (own, _)) in effect.states.iter().enumerate() {
                tape.name(own, Place::State(state + k));
                names.push(own.clone());
            }
            for added in effect.adds.iter().filter(|added| matches!(added.to, Target::Own(_))) {
                let numbers: Vec<usize> = added.parameters.iter().map(|k| first + k).collect();
                let error = key(format!("effect `{}`", effect.text.id));
                rates.push(tape.add(&added.sentence, &numbers).map_err(error)?);
            }
        }
        names.extend(tape.lags().iter().map(|_| "a lag".to_string()));
        rates.extend(tape.lags().iter().map(|lag| lag.rate));
        let starts: Vec<usize> = tape.lags().iter().map(|lag| lag.start).collect();
        let arguments = tape.switches().to_vec();
        let [rates, starts, arguments] = [rates, starts, arguments]
            .map(|registers| registers.into_iter().map(|register| tape.row(register)).collect());
        let [output, read] = [output, read].map(|register| tape.row(register));
        Ok(System { tape, names, rates, starts, arguments, output, read, inputs: plant.inputs.len() })
    }

    /// Number of states, those of lags included.
    pub fn states(&self) -> usize {
        self.names.len()
    }
}
