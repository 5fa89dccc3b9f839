//! Operators that remember, in equations of motion: a lag and a play bring a state with them, a delay a further input.

use super::graph::{MOST_ARGUMENTS, Source, Step};
use super::{Delayed, Memory, Tape};
use crate::operator::{MAX, MIN};

impl Tape {
    /// The state that the next operator brings with it.
    fn next_state(&mut self) -> usize {
        self.graph.source(Source::State(self.states + self.memories.len()))
    }

    /// z′ = (e − z)/τ.
    pub(super) fn lag(&mut self, of: usize, tau: usize, start: usize) -> usize {
        let z = self.next_state();
        let behind = self.graph.push(Step::Subtract(of, z));
        let rate = self.graph.push(Step::Divide(behind, tau));
        self.memories.push(Memory { rate, start, play: None });
        z
    }

    /// What follows a signal across a gap of ±r: where it was after the last step, moved by what pushes it since. None where
    /// the signal is no sum of states and inputs times fixed numbers, or the gap is not fixed.
    pub(super) fn play(&mut self, of: usize, gap: usize, start: usize) -> Option<usize> {
        let row = self.graph.row(of);
        let slopes = row.by.iter().filter(|(source, _)| !matches!(source, Source::Parameter(_)));
        if !self.is_fixed(gap) || slopes.into_iter().any(|(_, slope)| !self.is_fixed(*slope)) {
            return None;
        }
        let z = self.next_state();
        let rate = self.graph.constant(0.0);
        self.memories.push(Memory { rate, start, play: Some([of, gap]) });
        let (upper, lower) = (self.graph.push(Step::Add(of, gap)), self.graph.push(Step::Subtract(of, gap)));
        let mut two = |operator, a, b| {
            let mut of = [0; MOST_ARGUMENTS];
            (of[0], of[1]) = (a, b);
            self.graph.push(Step::Apply { operator, of, count: 2 })
        };
        let below = two(&MIN, z, upper);
        Some(two(&MAX, below, lower))
    }

    /// An expression of inputs some time ago; none where it holds anything else that changes, or the time is not fixed.
    pub(super) fn delay(&mut self, of: usize, by: usize) -> Option<usize> {
        if !self.is_fixed(by) {
            return None;
        }
        let mut ago: Vec<usize> = (0..=of).collect();
        for k in self.graph.below(of) {
            let at = |k: usize| ago[k];
            ago[k] = match self.graph.steps[k] {
                Step::Constant(_) | Step::Source(Source::Parameter(_)) => k,
                Step::Source(Source::Input(input)) if input < self.inputs => self.input_ago(input, by),
                Step::Add(a, b) => self.graph.push(Step::Add(at(a), at(b))),
                Step::Subtract(a, b) => self.graph.push(Step::Subtract(at(a), at(b))),
                Step::Multiply(a, b) => self.graph.push(Step::Multiply(at(a), at(b))),
                Step::Divide(a, b) => self.graph.push(Step::Divide(at(a), at(b))),
                Step::Apply { operator, of, count } => {
                    let mut to = [0; MOST_ARGUMENTS];
                    to.iter_mut().zip(&of[..count]).for_each(|(to, of)| *to = at(*of));
                    self.graph.push(Step::Apply { operator, of: to, count })
                }
                Step::Source(_) | Step::Switch(..) | Step::Slope { .. } => return None,
            };
        }
        Some(ago[of])
    }

    fn input_ago(&mut self, input: usize, by: usize) -> usize {
        let same = |delayed: &Delayed| delayed.input == input && delayed.by == by;
        let number = self.delayed.iter().position(same).unwrap_or_else(|| {
            self.delayed.push(Delayed { input, by });
            self.delayed.len() - 1
        });
        self.graph.source(Source::Input(self.inputs + number))
    }

    /// The rate of an expression of states and the time; none before the rates of all states are known, or where its
    /// derivatives have no derivative here.
    pub(super) fn rate(&mut self, of: usize) -> Option<usize> {
        let row = self.graph.row(of);
        let mut sum = self.graph.constant(0.0);
        for (source, slope) in row.by {
            if self.graph.below(slope).iter().any(|k| matches!(self.graph.steps[*k], Step::Slope { .. })) {
                return None;
            }
            let along = match source {
                Source::State(k) => *self.rates.get(k)?,
                Source::Time => self.graph.constant(1.0),
                Source::Parameter(_) => continue,
                Source::Input(_) => return None,
            };
            let part = self.graph.push(Step::Multiply(slope, along));
            sum = self.graph.push(Step::Add(sum, part));
        }
        Some(sum)
    }

    /// Whether a value depends on parameters alone.
    fn is_fixed(&self, register: usize) -> bool {
        let fixed = |k: &usize| match self.graph.steps[*k] {
            Step::Source(Source::Parameter(_)) => true,
            Step::Source(_) | Step::Switch(..) => false,
            _ => true,
        };
        self.graph.below(register).iter().all(fixed)
    }
}
