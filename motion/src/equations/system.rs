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
    /// The rate of every state, those that operators bring with them last.
    pub(super) rates: Vec<Row>,
    /// Where the states that operators bring with them begin.
    pub(super) starts: Vec<Row>,
    /// The plays.
    pub(super) plays: Vec<Play>,
    /// Further inputs: which of the others, and how long ago.
    pub(super) delays: Vec<(usize, Row)>,
    /// The arguments of switches.
    pub(super) arguments: Vec<Row>,
    pub(super) output: Row,
    /// The output without effects.
    pub(super) read: Row,
    pub(super) inputs: usize,
}

/// What follows a signal across a gap.
#[derive(Clone)]
pub struct Play {
    /// The state that says where it was after the last step.
    pub(super) state: usize,
    /// The signal, and the gap.
    pub(super) rows: [Row; 2],
}

impl System {
    /// A plant with effects, in whose order offsets and limits of an input or the output follow each other.
    ///
    /// # Errors
    /// [`EquationsError::Expression`] where no equation of motion can hold an operator.
    pub fn new(plant: &Plant, effects: &[&MotionEffect]) -> Result<System, EquationsError> {
        let own_states: usize = effects.iter().map(|effect| effect.states.len()).sum();
        let mut tape = Tape::new(plant.states.len() + own_states, plant.inputs.len());
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
        rates.extend(tape.memories().iter().map(|memory| memory.rate));
        tape.moves(&rates);
        // What acts on the output may hold rates, and memories of its own.
        let before = tape.memories().len();
        let output = add(&mut tape, Target::Output, read, Some(name))?;
        rates.extend(tape.memories()[before..].iter().map(|memory| memory.rate));
        names.extend(tape.memories().iter().map(|_| "a lag".to_string()));
        Ok(System::of(tape, names, rates, [output, read], plant.inputs.len()))
    }

    /// What is computed, with its derivatives.
    fn of(
        mut tape: Tape,
        names: Vec<String>,
        rates: Vec<usize>,
        outputs: [usize; 2],
        inputs: usize,
    ) -> System {
        let (memories, delayed) = (tape.memories().to_vec(), tape.delayed().to_vec());
        let starts = memories.iter().map(|memory| memory.start).collect();
        let arguments = tape.switches().to_vec();
        let [rates, starts, arguments] = [rates, starts, arguments].map(|registers: Vec<usize>| {
            registers.into_iter().map(|register| tape.row(register)).collect::<Vec<Row>>()
        });
        let first = rates.len() - memories.len();
        let plays = memories.iter().enumerate().filter_map(|(k, memory)| {
            Some(Play { state: first + k, rows: memory.play?.map(|register| tape.row(register)) })
        });
        let plays = plays.collect();
        let delays = delayed.iter().map(|delayed| (delayed.input, tape.row(delayed.by))).collect();
        let [output, read] = outputs.map(|register| tape.row(register));
        System { tape, names, rates, starts, plays, delays, arguments, output, read, inputs }
    }

    /// Number of states, those that operators bring with them included.
    pub fn states(&self) -> usize {
        self.names.len()
    }
}
