//! An expression in `f64`, call by call, with a bound of what `f64` rounds: every value carries what it may be off, which
//! its slopes pass on.

use physics::{ELEMENTS, Operation};

use super::model::CHAIN;
use crate::physics::Tree;

/// A value and what it may be off.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub value: f64,
    pub error: f64,
}

impl Near {
    /// A number that was rounded a few times.
    pub fn rounded(value: f64) -> Near {
        Near { value, error: value.abs() * CHAIN }
    }

    fn plus(self, error: f64) -> Near {
        Near { error: self.error + error, ..self }
    }
}

/// What an operator keeps from call to call.
#[derive(Debug, Clone, Default)]
pub(super) struct Cell {
    values: Vec<f64>,
    /// The input at the call before.
    before: f64,
    /// The largest error of the input so far.
    error: f64,
}

/// An expression somewhere in a sequence of calls.
pub(super) struct Running<'a> {
    /// One for every operator that remembers, in the order of the evaluation.
    pub cells: &'a mut Vec<Cell>,
    /// How many of them this call has reached.
    pub next: usize,
    pub observe: &'a dyn Fn(&str) -> f64,
    /// Whether this is a first call, and how many came before.
    pub calls: (bool, u64),
    pub period_s: f64,
}

impl Running<'_> {
    pub fn value(&mut self, tree: &Tree) -> Near {
        match tree {
            Tree::Number(value) => Near { value: *value, error: 0.0 },
            Tree::Observed(name) => Near::rounded((self.observe)(name)),
            Tree::Apply(operation, of) => {
                let of: Vec<Near> = of.iter().map(|argument| self.value(argument)).collect();
                if operation.remembers() {
                    self.remembered(*operation, &of)
                } else {
                    at_once(*operation, &of)
                }
            }
        }
    }

    fn remembered(&mut self, operation: Operation, of: &[Near]) -> Near {
        if self.next == self.cells.len() {
            self.cells.push(Cell::default());
        }
        let cell = &mut self.cells[self.next];
        self.next += 1;
        let (begins, calls) = self.calls;
        let (now, start) = (of[0], *of.get(2).unwrap_or(&of[0]));
        if begins {
            *cell = Cell { values: vec![start.value], before: now.value, error: start.error };
        }
        cell.error = cell.error.max(now.error);
        let size = now.value.abs() + cell.before.abs() + cell.values[0].abs();
        let value = match operation {
            Operation::LowPass => {
                let ratio = self.period_s / of[1].value;
                let (gone, e) = (-(-ratio).exp_m1(), cell.before);
                if !begins {
                    let y = cell.values[0];
                    cell.values[0] = y + gone * (e - y) + (now.value - e) * (1.0 - gone / ratio);
                }
                // Of what every call rounds all but the last 1/(1 − e^(−T/τ)) have faded.
                let rounded = size * CHAIN * (1.0 + 0.25 * (calls as f64).min(1.0 + 1.0 / ratio));
                Near { value: cell.values[0], error: cell.error + rounded }
            }
            Operation::Rate => {
                let value = (now.value - cell.before) / self.period_s;
                Near { value, error: (2.0 * cell.error + size * CHAIN) / self.period_s }
            }
            Operation::Delay => {
                // Straight between two calls; before the first it was what it is there.
                let ago = of[1].value / self.period_s;
                cell.values.push(now.value);
                let last = cell.values.len() - 1;
                let at = |calls: f64| cell.values[last.saturating_sub(calls as usize)];
                let (late, early) = (at(ago.floor()), at(ago.floor() + 1.0));
                cell.values.drain(..last.saturating_sub(ago as usize + 1));
                Near { value: late + ago.fract() * (early - late), error: cell.error }
                    .plus((late.abs() + early.abs()) * CHAIN * (1.0 + ago))
            }
            _ => {
                let stated = of.get(3).map_or(ELEMENTS, |count| count.value.round() as usize);
                let elements = if operation == Operation::Plays { stated } else { 1 };
                cell.values.resize(elements, start.value);
                for (k, p) in (1..).zip(&mut cell.values) {
                    let gap = of[1].value * k as f64 / elements as f64;
                    *p = p.clamp(now.value - gap, now.value + gap);
                }
                let value = cell.values.iter().sum::<f64>() / elements as f64;
                Near { value, error: cell.error + of[1].error }.plus((size + of[1].value) * CHAIN)
            }
        };
        cell.before = now.value;
        value
    }
}

/// An operator without memory.
fn at_once(operation: Operation, of: &[Near]) -> Near {
    let x: Vec<f64> = of.iter().map(|near| near.value).collect();
    let (value, slopes) = operation.at(&x);
    let moved: f64 = of.iter().zip(&slopes).map(|(near, slope)| near.error * slope.abs()).sum();
    let all: f64 = of.iter().map(|near| near.error).sum();
    match operation {
        // Beside a corner either side may be right.
        Operation::Abs | Operation::Min | Operation::Max | Operation::Hinge => Near { value, error: all },
        Operation::Table => {
            let error = of[0].error * physics::table::steepest(&x) + value.abs() * CHAIN;
            Near { value, error }
        }
        // Words are compared exactly: within what is rounded, a threshold counts as reached.
        Operation::Step => Near { value: f64::from(u8::from(x[0] >= x[1] - all)), error: 0.0 },
        Operation::Sign if x[0].abs() <= all => Near { value: 0.0, error: 0.0 },
        Operation::Sign => Near { value, error: 0.0 },
        _ => Near { value, error: moved + value.abs() * CHAIN },
    }
}
