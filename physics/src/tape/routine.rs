//! A graph with numbers for its parameters, and what is run of it at an instant: a list of operations on one file of
//! registers, which holds the states first, then the inputs and the time.

use crate::operator::Operator;

use super::Side;
use super::graph::{Graph, Known, MOST_ARGUMENTS, Source, Step};
use super::slopes::Row;

/// A graph with numbers for its parameters.
pub struct Bound<'a> {
    graph: &'a Graph,
    /// Values that are known now.
    known: Vec<Option<f64>>,
    /// The step in whose place every step stands: itself, or the one whose value it has.
    same: Vec<usize>,
    /// Place of every step in the file of registers; the derivatives of an applied operator follow its value.
    places: Vec<usize>,
    size: usize,
}

/// Where a value and its derivatives stand after a routine was run.
#[derive(Debug, Clone)]
pub struct Places {
    /// The value.
    pub value: usize,
    /// Numbers of states, and the derivatives by them.
    pub states: Vec<(usize, usize)>,
    /// Likewise of parameters.
    pub parameters: Vec<(usize, usize)>,
    /// Likewise of inputs.
    pub inputs: Vec<(usize, usize)>,
    /// The derivative by the time.
    pub time: Option<usize>,
}

#[derive(Clone, Copy)]
enum What {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// a b + c
    MultiplyAdd,
    /// a b − c
    MultiplySubtract,
    /// c − a b
    SubtractFrom,
    /// Number `a`, of the values `b`.
    Switch,
    /// Number `a` of those that are applied.
    Apply,
}

/// `to` becomes what `a`, `b` and `c` give.
#[derive(Clone, Copy)]
struct Operation {
    what: What,
    to: u32,
    a: u32,
    b: u32,
    c: u32,
}

/// An operator with the places of its arguments.
struct Applied {
    operator: &'static dyn Operator,
    of: [usize; MOST_ARGUMENTS],
    count: usize,
}

/// The operations that some values need, each after those that it needs.
pub struct Routine {
    operations: Vec<Operation>,
    applied: Vec<Applied>,
    switched: Vec<[f64; 2]>,
    /// Where the values stand.
    pub rows: Vec<Places>,
}

impl<'a> Bound<'a> {
    pub(super) fn new(graph: &'a Graph, parameters: &[f64], states: usize, inputs: usize) -> Bound<'a> {
        let count = graph.steps.len();
        let (mut known, mut same) = (vec![None; count], Vec::with_capacity(count));
        let mut places = Vec::with_capacity(count);
        let mut size = states + inputs + 1;
        for (k, step) in graph.steps.iter().enumerate() {
            let fate = match step {
                Step::Source(Source::Parameter(k)) => Known::Value(parameters[*k]),
                _ => step.known(&graph.steps, |k| known[same[k]]),
            };
            same.push(match fate {
                Known::Same(other) => same[other],
                _ => k,
            });
            if let Known::Value(value) = fate {
                known[k] = Some(value);
            }
            places.push(match step {
                Step::Source(Source::State(state)) => *state,
                Step::Source(Source::Input(input)) => states + input,
                Step::Source(Source::Time) => states + inputs,
                Step::Slope { of, by } => places[*of] + 1 + by,
                _ => size,
            });
            size += if let Step::Apply { count, .. } = step { 1 + count } else { 1 };
        }
        Bound { graph, known, same, places, size }
    }

    /// The file of registers, with all that is known in it.
    pub fn registers(&self) -> Vec<f64> {
        let mut registers = vec![0.0; self.size];
        for (place, value) in self.places.iter().zip(&self.known) {
            if let Some(value) = value {
                registers[*place] = *value;
            }
        }
        registers
    }

    /// What has to be run for some values, and for their derivatives by what is wanted.
    pub fn routine(&self, rows: &[Row], wanted: impl Fn(Source) -> bool) -> Routine {
        let rows: Vec<Row> = rows.iter().map(|row| self.left(row, &wanted)).collect();
        // How often the value of every step is read.
        let mut reads = vec![0_usize; self.graph.steps.len()];
        for row in &rows {
            // What is wanted stays in its register.
            reads[row.value] += 2;
            row.by.iter().for_each(|(_, register)| reads[*register] += 2);
        }
        for (k, step) in self.graph.steps.iter().enumerate().rev() {
            if reads[k] > 0 && self.known[k].is_none() {
                step.of().for_each(|of| reads[self.same[of]] += 1);
            }
        }
        let rows = rows.iter().map(|row| self.places(row)).collect();
        let mut routine = Routine { operations: Vec::new(), applied: Vec::new(), switched: Vec::new(), rows };
        let computed = |k: &usize| reads[*k] > 0 && self.known[*k].is_none();
        // The product that every sum takes up, which nothing else reads.
        let product = |k: usize| match self.graph.steps[k] {
            Step::Add(a, b) | Step::Subtract(a, b) => {
                let single = |of: &usize| {
                    matches!(self.graph.steps[*of], Step::Multiply(..)) && computed(of) && reads[*of] == 1
                };
                [self.same[b], self.same[a]].into_iter().find(single)
            }
            _ => None,
        };
        let mut taken = vec![false; reads.len()];
        (0..reads.len()).filter(computed).filter_map(product).for_each(|k| taken[k] = true);
        for k in (0..reads.len()).filter(|k| computed(k) && !taken[*k]) {
            routine.add(self, k, product(k));
        }
        routine
    }

    /// What is left of a row: derivatives that are wanted and not zero.
    fn left(&self, row: &Row, wanted: &impl Fn(Source) -> bool) -> Row {
        let by = row.by.iter().map(|(source, register)| (*source, self.same[*register]));
        let by = by.filter(|(source, register)| wanted(*source) && self.known[*register] != Some(0.0));
        Row { value: self.same[row.value], by: by.collect() }
    }

    fn places(&self, row: &Row) -> Places {
        let (mut states, mut parameters, mut inputs) = (Vec::new(), Vec::new(), Vec::new());
        let mut time = None;
        for (source, register) in &row.by {
            let place = self.places[*register];
            match source {
                Source::State(k) => states.push((*k, place)),
                Source::Parameter(k) => parameters.push((*k, place)),
                Source::Input(k) => inputs.push((*k, place)),
                Source::Time => time = Some(place),
            }
        }
        Places { value: self.places[row.value], states, parameters, inputs, time }
    }
}

impl Routine {
    /// Appends a step, which may take up a product.
    fn add(&mut self, bound: &Bound, step: usize, product: Option<usize>) {
        let place = |k: usize| bound.places[bound.same[k]];
        let factors = product.map(|k| match bound.graph.steps[k] {
            Step::Multiply(a, b) => [place(a), place(b)],
            _ => unreachable!("only products are taken up"),
        });
        let (what, [a, b, c]) = match (bound.graph.steps[step], factors) {
            (Step::Add(a, b), Some([x, y])) => {
                let other = if Some(bound.same[b]) == product { a } else { b };
                (What::MultiplyAdd, [x, y, place(other)])
            }
            (Step::Subtract(a, b), Some([x, y])) if Some(bound.same[b]) == product => {
                (What::SubtractFrom, [x, y, place(a)])
            }
            (Step::Subtract(_, b), Some([x, y])) => (What::MultiplySubtract, [x, y, place(b)]),
            (Step::Add(a, b), None) => (What::Add, [place(a), place(b), 0]),
            (Step::Subtract(a, b), None) => (What::Subtract, [place(a), place(b), 0]),
            (Step::Multiply(a, b), _) => (What::Multiply, [place(a), place(b), 0]),
            (Step::Divide(a, b), _) => (What::Divide, [place(a), place(b), 0]),
            (Step::Switch(number, values), _) => {
                self.switched.push(values);
                (What::Switch, [number, self.switched.len() - 1, 0])
            }
            (Step::Apply { operator, of, count }, _) => {
                self.applied.push(Applied { operator, of: of.map(place), count });
                (What::Apply, [self.applied.len() - 1, 0, 0])
            }
            // They stand where they are.
            (Step::Constant(_) | Step::Source(_) | Step::Slope { .. }, _) => return,
        };
        let [to, a, b, c] = [bound.places[step], a, b, c].map(|place| place as u32);
        self.operations.push(Operation { what, to, a, b, c });
    }

    /// Number of operations.
    pub fn length(&self) -> usize {
        self.operations.len()
    }

    /// Computes its values in a file of registers.
    #[inline(always)]
    pub fn run(&self, sides: &[Side], registers: &mut [f64]) {
        for Operation { what, to, a, b, c } in &self.operations {
            let [to, a, b, c] = [*to, *a, *b, *c].map(|place| place as usize);
            registers[to] = match what {
                What::Add => registers[a] + registers[b],
                What::Subtract => registers[a] - registers[b],
                What::Multiply => registers[a] * registers[b],
                What::Divide => registers[a] / registers[b],
                What::MultiplyAdd => registers[a] * registers[b] + registers[c],
                What::MultiplySubtract => registers[a] * registers[b] - registers[c],
                What::SubtractFrom => registers[c] - registers[a] * registers[b],
                What::Switch => {
                    let [below, above] = self.switched[b];
                    match sides[a] {
                        Side::Below => below,
                        Side::Above => above,
                        Side::Held(part) => below + 0.5 * (1.0 + part) * (above - below),
                    }
                }
                What::Apply => self.applied[a].run(to, registers),
            };
        }
    }
}

impl Applied {
    /// The operator's value; its derivatives are written behind `to`.
    #[inline(never)]
    fn run(&self, to: usize, registers: &mut [f64]) -> f64 {
        let mut values = [0.0; MOST_ARGUMENTS];
        for (value, place) in values.iter_mut().zip(&self.of[..self.count]) {
            *value = registers[*place];
        }
        self.operator.at(&values[..self.count], &mut registers[to + 1..=to + self.count])
    }
}
