//! Sentences compiled once into a graph of values with their derivatives, which is then run at every instant of a
//! simulation. What stands twice is computed once; what depends on parameters only is computed once a run
//! ([`Bound`]); a [`Routine`] is what has to be computed for some of the values.
//!
//! A lag is a further state of the simulation, a play one that is set after every step, a delay a further input. A sign
//! and a step jump, a hinge, `abs`, `min` and `max` bend: which side they are on is a [`Side`] that the simulation holds
//! while it moves, and changes where the argument passes zero.

mod graph;
mod memory;
mod routine;
mod slopes;

use std::collections::BTreeMap;

use crate::check::{Applied, Node, Sentence};
use crate::error::ExpressionError;
use crate::operator::{Operation, Operator};

pub use graph::Source;
use graph::{Graph, MOST_ARGUMENTS, Step};
pub use routine::{Bound, Places, Routine};
pub use slopes::Row;

/// Where a name finds its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// A state, by number.
    State(usize),
    /// An input, by number.
    Input(usize),
    /// The time in seconds.
    Time,
    /// What an earlier sentence gave: its register.
    Register(usize),
}

/// On which side of zero the argument of a sign or a step is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Side {
    /// Below.
    Below,
    /// Above, or at zero.
    Above,
    /// It is held at zero, and the value is so far from that below (−1) to that above (1).
    Held(f64),
}

/// A state that an operator brings with it, of a lag or a play.
#[derive(Debug, Clone)]
pub struct Memory {
    /// Register of its rate, which is zero of a play.
    pub rate: usize,
    /// Register of where it begins.
    pub start: usize,
    /// Of a play the registers of what it follows, and of its gap: the state is where it was after the last step.
    pub play: Option<[usize; 2]>,
}

/// A further input: what another one was some time ago.
#[derive(Debug, Clone)]
pub struct Delayed {
    /// Which.
    pub input: usize,
    /// Register of the time in seconds.
    pub by: usize,
}

/// Sentences as a graph of values.
#[derive(Clone, Default)]
pub struct Tape {
    graph: Graph,
    names: BTreeMap<String, Place>,
    states: usize,
    inputs: usize,
    memories: Vec<Memory>,
    delayed: Vec<Delayed>,
    /// Registers of the rates of all states, once they are known.
    rates: Vec<usize>,
    /// Registers of the arguments of switches.
    switches: Vec<usize>,
}

impl Tape {
    /// An empty tape of a simulation with so many states and inputs.
    pub fn new(states: usize, inputs: usize) -> Tape {
        Tape { states, inputs, ..Tape::default() }
    }

    /// Gives a name a meaning for the sentences that follow.
    pub fn name(&mut self, name: &str, place: Place) {
        self.names.insert(name.to_string(), place);
    }

    /// Appends a sentence, whose parameters are those of these numbers; the register of its value.
    ///
    /// # Errors
    /// The place of an operator that no equation of motion can hold, or of a name without meaning.
    pub fn add(&mut self, sentence: &Sentence, parameters: &[usize]) -> Result<usize, ExpressionError> {
        self.node(&sentence.root, sentence, parameters)
    }

    /// The register of a sum of two.
    pub fn sum(&mut self, a: usize, b: usize) -> usize {
        self.graph.push(Step::Add(a, b))
    }

    /// The register of a name's value.
    pub fn value_of(&mut self, place: Place) -> usize {
        match place {
            Place::State(k) => self.graph.source(Source::State(k)),
            Place::Input(k) => self.graph.source(Source::Input(k)),
            Place::Time => self.graph.source(Source::Time),
            Place::Register(register) => register,
        }
    }

    /// A value with its derivatives.
    pub fn row(&mut self, register: usize) -> Row {
        self.graph.row(register)
    }

    /// Says what the rates of the states are, so that sentences that follow can hold the rate of a value.
    pub fn moves(&mut self, rates: &[usize]) {
        self.rates = rates.to_vec();
    }

    /// The tape with numbers for its parameters.
    pub fn bound(&self, parameters: &[f64]) -> Bound<'_> {
        let (states, inputs) = (self.states + self.memories.len(), self.inputs + self.delayed.len());
        Bound::new(&self.graph, parameters, states, inputs)
    }

    fn node(
        &mut self,
        node: &Node,
        sentence: &Sentence,
        parameters: &[usize],
    ) -> Result<usize, ExpressionError> {
        let (operator, arguments, span) = match node {
            Node::Constant(value) => return Ok(self.graph.push(Step::Constant(*value))),
            Node::Parameter(index) => return Ok(self.graph.source(Source::Parameter(parameters[*index]))),
            Node::Column(name) => {
                let place = self.names.get(name).copied();
                let whole = 0..sentence.text.len();
                let unknown = || {
                    ExpressionError::new(&sentence.text, &whole, format!("`{name}` has no value in motion"))
                };
                return Ok(self.value_of(place.ok_or_else(unknown)?));
            }
            Node::Apply(Applied { operator, arguments, span, .. }) => (*operator, arguments, span),
        };
        let mut registers = Vec::with_capacity(arguments.len());
        for (argument, factor) in arguments {
            let register = self.node(argument, sentence, parameters)?;
            registers.push(self.graph.scaled(register, *factor));
        }
        let refused =
            |why: &str| ExpressionError::new(&sentence.text, span, format!("`{}` {why}", operator.name()));
        self.applied(operator, &registers).map_err(refused)
    }

    /// The register of an operator's value, of those of its arguments.
    ///
    /// # Errors
    /// Why no equation of motion can hold it.
    fn applied(&mut self, operator: &'static dyn Operator, all: &[usize]) -> Result<usize, &'static str> {
        if operator.operation() == Operation::Table {
            return Ok(self.table(all));
        }
        let count = all.len();
        let mut of = [0; MOST_ARGUMENTS];
        of[..count].copy_from_slice(all);
        Ok(match operator.operation() {
            Operation::Sum => self.graph.push(Step::Add(of[0], of[1])),
            Operation::Difference => self.graph.push(Step::Subtract(of[0], of[1])),
            Operation::Product => self.graph.push(Step::Multiply(of[0], of[1])),
            Operation::Quotient => self.graph.push(Step::Divide(of[0], of[1])),
            Operation::Negative => self.graph.negative(of[0]),
            Operation::Power => self.graph.power(operator, of),
            Operation::Sign => self.switch(of[0], [-1.0, 1.0]),
            Operation::Step => {
                let above = self.graph.push(Step::Subtract(of[0], of[1]));
                self.switch(above, [0.0, 1.0])
            }
            Operation::Abs => {
                let side = self.switch(of[0], [-1.0, 1.0]);
                self.graph.push(Step::Multiply(of[0], side))
            }
            Operation::Hinge => self.above(of[0], of[1]),
            Operation::Max => {
                let above = self.above(of[0], of[1]);
                self.graph.push(Step::Add(of[1], above))
            }
            Operation::Min => {
                let above = self.above(of[0], of[1]);
                self.graph.push(Step::Subtract(of[0], above))
            }
            Operation::LowPass => self.lag(of[0], of[1], if count > 2 { of[2] } else { of[0] }),
            Operation::Play => self.play(of[0], of[1], if count > 2 { of[2] } else { of[0] }).ok_or(
                "follows a sum of states and inputs times numbers, across a gap that stays as it is",
            )?,
            Operation::Delay => (self.delay(of[0], of[1]))
                .ok_or("is computed of inputs alone, by a time that stays as it is")?,
            Operation::Rate => self.rate(of[0]).ok_or(
                "stands in an effect on the output alone, of states and not of inputs; elsewhere write its equation",
            )?,
            _ if operator.remembers() || operator.of_recording() => {
                return Err("is not computed in an equation of motion: write its state as a state of its own");
            }
            _ => self.graph.push(Step::Apply { operator, of, count }),
        })
    }

    /// A table: what its slope changes by at every place, times how far the quantity is beyond that.
    fn table(&mut self, of: &[usize]) -> usize {
        let steps = self.graph.constant((of.len() - 4) as f64);
        let [beyond, length] = [of[0], of[2]].map(|k| self.graph.push(Step::Subtract(k, of[1])));
        let part = self.graph.push(Step::Divide(beyond, length));
        let along = self.graph.push(Step::Multiply(part, steps));
        let values = &of[3..];
        let (mut sum, mut before) = (values[0], self.graph.constant(0.0));
        for k in 0..values.len() {
            let rise = match values.get(k + 1) {
                Some(next) => self.graph.push(Step::Subtract(*next, values[k])),
                None => self.graph.constant(0.0),
            };
            let change = self.graph.push(Step::Subtract(rise, before));
            let place = self.graph.constant(k as f64);
            let above = self.above(along, place);
            let part = self.graph.push(Step::Multiply(change, above));
            sum = self.graph.push(Step::Add(sum, part));
            before = rise;
        }
        sum
    }

    /// What one value is above another, or nothing. Its bend is a switch, so that a step of a simulation ends there.
    fn above(&mut self, value: usize, other: usize) -> usize {
        let above = self.graph.push(Step::Subtract(value, other));
        let side = self.switch(above, [0.0, 1.0]);
        self.graph.push(Step::Multiply(above, side))
    }

    fn switch(&mut self, argument: usize, values: [f64; 2]) -> usize {
        let number = self.switches.iter().position(|register| *register == argument).unwrap_or_else(|| {
            self.switches.push(argument);
            self.switches.len() - 1
        });
        self.graph.push(Step::Switch(number, values))
    }

    /// The states that operators bring with them, in the order in which each depends on earlier ones only; they follow the
    /// others.
    pub fn memories(&self) -> &[Memory] {
        &self.memories
    }

    /// Further inputs, which follow the others.
    pub fn delayed(&self) -> &[Delayed] {
        &self.delayed
    }

    /// Registers of the arguments of signs and steps.
    pub fn switches(&self) -> &[usize] {
        &self.switches
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Names, Parameter};
    use crate::interval::Interval;
    use crate::parse::parse;
    use crate::unit::Unit;

    fn read(text: &str, unit: &str) -> Sentence {
        let units = |name: &str| match name {
            "x" => Unit::parse("rad").ok(),
            "v" => Unit::parse("rad/s").ok(),
            _ => None,
        };
        let range = Some(Interval { from: 0.1, to: 10.0 });
        let unit_of = |name: &str| Unit::parse(if name == "tau" { "s" } else { "1/s^2" }).unwrap();
        let all = ["a", "tau"].map(|name| Parameter { name: name.into(), unit: unit_of(name), range });
        let names = parse(text).unwrap();
        let used: Vec<Parameter> =
            all.into_iter().filter(|p| names.names().contains(&p.name.as_str())).collect();
        let names = Names { column: &units, known: &[], parameters: &used };
        Sentence::read(text, Some(&Unit::parse(unit).unwrap()), &names).unwrap()
    }

    #[test]
    fn a_tape_gives_values_and_derivatives() {
        let mut tape = Tape::new(2, 0);
        tape.name("x", Place::State(0));
        tape.name("v", Place::State(1));
        let swing = tape.add(&read("-a * sin(x)", "1/s^2"), &[0]).unwrap();
        let again = tape.add(&read("-a * sin(x)", "1/s^2"), &[0]).unwrap();
        assert_eq!(swing, again, "what stands twice is computed once");
        let power = tape.add(&read("a * x^3 / (1 + x^2)", "1/s^2"), &[0]).unwrap();
        let sign = tape.add(&read("sign(v) * a", "1/s^2"), &[0]).unwrap();
        let lagged = tape.add(&read("lowpass(x, tau)", "rad"), &[1]).unwrap();
        assert_eq!(tape.switches().len(), 1);
        let lag = tape.memories()[0].rate;
        let rows = [swing, power, sign, lagged, lag].map(|register| tape.row(register));
        let (x, a, tau) = (0.5, 3.0, 2.0);
        let bound = tape.bound(&[a, tau]);
        let routine = bound.routine(&rows, |_| true);
        let mut registers = bound.registers();
        registers[..3].copy_from_slice(&[x, -0.2, 0.7]);
        routine.run(&[Side::Held(0.5)], &mut registers);
        let at = |k: usize| registers[routine.rows[k].value];
        let by = |all: fn(&Places) -> &Vec<(usize, usize)>, row: usize, k: usize| {
            let found = all(&routine.rows[row]).iter().find(|(source, _)| *source == k);
            found.map_or(0.0, |(_, place)| registers[*place])
        };
        let near =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        near(at(0), -a * x.sin());
        near(by(|row| &row.states, 0, 0), -a * x.cos());
        near(by(|row| &row.parameters, 0, 0), -x.sin());
        let square = 1.0 + x * x;
        near(at(1), a * x.powi(3) / square);
        near(by(|row| &row.states, 1, 0), a * x * x * (3.0 + x * x) / (square * square));
        near(by(|row| &row.parameters, 1, 0), x.powi(3) / square);
        near(at(2), 1.5);
        near(by(|row| &row.parameters, 2, 0), 0.5);
        near(at(3), 0.7);
        near(at(4), (x - 0.7) / tau);
        near(by(|row| &row.states, 4, 2), -1.0 / tau);
        near(by(|row| &row.parameters, 4, 1), -(x - 0.7) / (tau * tau));
        assert!(tape.add(&read("a * plays(x, 0.1)", "rad/s^2"), &[0]).is_err());
        assert!(tape.add(&read("a * delay(x, tau)", "rad/s^2"), &[0, 1]).is_err(), "a state has no past");
    }

    #[test]
    fn a_table_is_its_bends() {
        let mut tape = Tape::new(2, 0);
        tape.name("x", Place::State(0));
        let sentence = read("table(x, -a * 1 [rad s^2], 2 [rad], 5, -1, 3, 2)", "1");
        let table = tape.add(&sentence, &[0]).unwrap();
        let row = tape.row(table);
        assert_eq!(tape.switches().len(), 4, "a step of a simulation ends at every place");
        let bound = tape.bound(&[1.0]);
        let routine = bound.routine(&[row], |_| true);
        for (x, value, slope, by_a) in [
            (-3.0, 5.0, 0.0, 0.0),
            (-0.5, 2.0, -6.0, -5.0),
            (0.25, 0.0, 4.0, 7.0 / 3.0),
            (9.0, 2.0, 0.0, 0.0),
        ] {
            let sides = [-1.0, 0.0, 1.0, 2.0].map(|at| if x < at { Side::Below } else { Side::Above });
            let mut registers = bound.registers();
            registers[0] = x;
            routine.run(&sides, &mut registers);
            let places = &routine.rows[0];
            let by = |all: &[(usize, usize)]| all.first().map_or(0.0, |(_, place)| registers[*place]);
            for (found, expected) in [
                (registers[places.value], value),
                (by(&places.states), slope),
                (by(&places.parameters), by_a),
            ] {
                assert!((found - expected).abs() < 1e-14, "at {x}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn what_a_routine_does_not_need_is_not_computed() {
        let mut tape = Tape::new(2, 0);
        tape.name("x", Place::State(0));
        let value = tape.add(&read("a * sin(x)", "1/s^2"), &[0]).unwrap();
        let row = tape.row(value);
        let nothing = tape.bound(&[0.0]);
        assert_eq!(nothing.routine(std::slice::from_ref(&row), |_| false).length(), 0, "a factor of zero");
        assert_eq!(
            nothing.routine(std::slice::from_ref(&row), |_| true).length(),
            1,
            "its derivative is the sine"
        );
        let bound = tape.bound(&[2.0]);
        assert_eq!(bound.routine(&[row], |_| false).length(), 2);
    }
}
