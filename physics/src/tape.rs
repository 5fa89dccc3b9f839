//! Sentences compiled once into steps over registers, which are then run at every instant of a simulation: with plain
//! numbers, or with numbers that carry their derivatives.
//!
//! A lag is a further state of the simulation. A sign and a step jump: which side they are on is a [`Side`] that the
//! simulation holds while it moves, and changes where the argument passes zero.

use std::collections::BTreeMap;

use crate::check::{Applied, Node, Sentence};
use crate::error::ExpressionError;
use crate::number::Number;
use crate::operator::{Operation, Operator};

/// Most arguments of an operator.
const MOST_ARGUMENTS: usize = 4;

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

#[derive(Clone)]
enum Step {
    Constant(f64),
    State(usize),
    Input(usize),
    Parameter(usize),
    Time,
    Scale(usize, f64),
    Add(usize, usize),
    Subtract(usize, usize),
    Multiply(usize, usize),
    /// The value of a switch, by number: that below and that above.
    Switch(usize, [f64; 2]),
    Apply {
        operator: &'static dyn Operator,
        of: [usize; MOST_ARGUMENTS],
        count: usize,
    },
}

/// A lag as a further state: z′ = (input − z)/τ.
#[derive(Debug, Clone)]
pub struct Lag {
    /// Number of the state.
    pub state: usize,
    /// Register of what is lagged.
    pub input: usize,
    /// Register of the time constant, in seconds.
    pub tau: usize,
    /// Register of where it begins.
    pub start: usize,
}

/// Sentences as steps.
#[derive(Clone, Default)]
pub struct Tape {
    steps: Vec<Step>,
    names: BTreeMap<String, Place>,
    states: usize,
    lags: Vec<Lag>,
    /// Registers of the arguments of switches.
    switches: Vec<usize>,
}

/// What a tape is run at.
pub struct Instant<'a, T> {
    /// The states, those of lags last.
    pub states: &'a [T],
    /// The inputs.
    pub inputs: &'a [T],
    /// The parameters.
    pub parameters: &'a [T],
    /// The time in seconds.
    pub t_s: T,
    /// On which side each switch is.
    pub sides: &'a [Side],
}

impl Tape {
    /// An empty tape of a simulation with so many states.
    pub fn new(states: usize) -> Tape {
        Tape { states, ..Tape::default() }
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
        self.push(Step::Add(a, b))
    }

    /// The register of a name's value.
    pub fn value_of(&mut self, place: Place) -> usize {
        match place {
            Place::State(k) => self.push(Step::State(k)),
            Place::Input(k) => self.push(Step::Input(k)),
            Place::Time => self.push(Step::Time),
            Place::Register(register) => register,
        }
    }

    /// The register of zero.
    pub fn zero(&mut self) -> usize {
        self.push(Step::Constant(0.0))
    }

    fn push(&mut self, step: Step) -> usize {
        let same = |other: &Step| match (other, &step) {
            (Step::Constant(a), Step::Constant(b)) => a.to_bits() == b.to_bits(),
            (Step::State(a), Step::State(b))
            | (Step::Input(a), Step::Input(b))
            | (Step::Parameter(a), Step::Parameter(b)) => a == b,
            (Step::Scale(a, x), Step::Scale(b, y)) => a == b && x == y,
            (Step::Add(a, b), Step::Add(c, d))
            | (Step::Subtract(a, b), Step::Subtract(c, d))
            | (Step::Multiply(a, b), Step::Multiply(c, d)) => (a, b) == (c, d),
            (Step::Apply { operator: p, of: a, count: n }, Step::Apply { operator: q, of: b, count: m }) => {
                p.operation() == q.operation() && n == m && a == b
            }
            _ => false,
        };
        // What was computed before is not computed again.
        self.steps.iter().position(same).unwrap_or_else(|| {
            self.steps.push(step);
            self.steps.len() - 1
        })
    }

    fn node(
        &mut self,
        node: &Node,
        sentence: &Sentence,
        parameters: &[usize],
    ) -> Result<usize, ExpressionError> {
        let (operator, arguments, span) = match node {
            Node::Constant(value) => return Ok(self.push(Step::Constant(*value))),
            Node::Parameter(index) => return Ok(self.push(Step::Parameter(parameters[*index]))),
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
        let mut of = [0; MOST_ARGUMENTS];
        for (place, (argument, factor)) in of.iter_mut().zip(arguments) {
            let register = self.node(argument, sentence, parameters)?;
            *place = if *factor == 1.0 { register } else { self.push(Step::Scale(register, *factor)) };
        }
        let count = arguments.len();
        Ok(match operator.operation() {
            Operation::Sum => self.push(Step::Add(of[0], of[1])),
            Operation::Difference => self.push(Step::Subtract(of[0], of[1])),
            Operation::Product => self.push(Step::Multiply(of[0], of[1])),
            Operation::Sign => self.switch(of[0], [-1.0, 1.0]),
            Operation::Step => {
                let above = self.push(Step::Subtract(of[0], of[1]));
                self.switch(above, [0.0, 1.0])
            }
            Operation::LowPass => {
                let state = self.states + self.lags.len();
                let start = if count > 2 { of[2] } else { of[0] };
                self.lags.push(Lag { state, input: of[0], tau: of[1], start });
                self.push(Step::State(state))
            }
            _ if operator.remembers() || operator.of_recording() => {
                let what = format!(
                    "`{}` is not computed in an equation of motion: write its state as a state of its own",
                    operator.name()
                );
                return Err(ExpressionError::new(&sentence.text, span, what));
            }
            _ => self.push(Step::Apply { operator, of, count }),
        })
    }

    fn switch(&mut self, argument: usize, values: [f64; 2]) -> usize {
        let number = self.switches.iter().position(|register| *register == argument).unwrap_or_else(|| {
            self.switches.push(argument);
            self.switches.len() - 1
        });
        self.push(Step::Switch(number, values))
    }

    /// The lags, in the order in which each depends on earlier ones only.
    pub fn lags(&self) -> &[Lag] {
        &self.lags
    }

    /// Registers of the arguments of signs and steps.
    pub fn switches(&self) -> &[usize] {
        &self.switches
    }

    /// Number of registers.
    pub fn registers(&self) -> usize {
        self.steps.len()
    }

    /// Computes all registers.
    #[inline(always)]
    pub fn run<T: Number>(&self, at: &Instant<T>, registers: &mut [T]) {
        let mut values = [0.0; MOST_ARGUMENTS];
        let mut slopes = [0.0; MOST_ARGUMENTS];
        let mut given = [T::from_f64(0.0); MOST_ARGUMENTS];
        for (k, step) in self.steps.iter().enumerate() {
            registers[k] = match step {
                Step::Constant(value) => T::from_f64(*value),
                Step::State(k) => at.states[*k],
                Step::Input(k) => at.inputs[*k],
                Step::Parameter(k) => at.parameters[*k],
                Step::Time => at.t_s,
                Step::Scale(a, factor) => registers[*a] * *factor,
                Step::Add(a, b) => registers[*a] + registers[*b],
                Step::Subtract(a, b) => registers[*a] - registers[*b],
                Step::Multiply(a, b) => registers[*a] * registers[*b],
                Step::Switch(number, [below, above]) => T::from_f64(match at.sides[*number] {
                    Side::Below => *below,
                    Side::Above => *above,
                    Side::Held(part) => below + 0.5 * (1.0 + part) * (above - below),
                }),
                Step::Apply { operator, of, count } => {
                    for (k, register) in of[..*count].iter().enumerate() {
                        given[k] = registers[*register];
                        values[k] = given[k].value();
                    }
                    let value = operator.at(&values[..*count], &mut slopes[..*count]);
                    T::of_several(value, &given[..*count], &slopes[..*count])
                }
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{Names, Parameter};
    use crate::interval::Interval;
    use crate::number::Dual;
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
        let mut tape = Tape::new(2);
        tape.name("x", Place::State(0));
        tape.name("v", Place::State(1));
        let swing = tape.add(&read("-a * sin(x)", "1/s^2"), &[0]).unwrap();
        let again = tape.add(&read("-a * sin(x)", "1/s^2"), &[0]).unwrap();
        assert_eq!(swing, again, "what stands twice is computed once");
        let sign = tape.add(&read("sign(v) * a", "1/s^2"), &[0]).unwrap();
        let lagged = tape.add(&read("lowpass(x, tau)", "rad"), &[1]).unwrap();
        assert_eq!((tape.lags()[0].state, tape.switches().len()), (2, 1));
        let number = |value, k| Dual::<3>::variable(value, k);
        let at = Instant {
            states: &[number(0.5, 0), Dual::from_f64(-0.2), Dual::from_f64(0.7)],
            inputs: &[],
            parameters: &[number(3.0, 1), Dual::from_f64(2.0)],
            t_s: Dual::from_f64(0.0),
            sides: &[Side::Held(0.5)],
        };
        let mut registers = vec![Dual::from_f64(0.0); tape.registers()];
        tape.run(&at, &mut registers);
        assert!((registers[swing].value + 3.0 * 0.5_f64.sin()).abs() < 1e-15);
        assert!((registers[swing].slopes[0] + 3.0 * 0.5_f64.cos()).abs() < 1e-15);
        assert!((registers[swing].slopes[1] + 0.5_f64.sin()).abs() < 1e-15);
        assert_eq!((registers[sign].value, registers[lagged].value), (1.5, 0.7));
        assert!(tape.add(&read("a * play(x, 0.1)", "rad/s^2"), &[0]).is_err());
    }
}
