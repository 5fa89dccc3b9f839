//! Derivatives of values, written as further values of the same graph.

use std::collections::BTreeMap;

use super::graph::{Graph, Source, Step};

/// The registers of the derivatives of a register's value.
type Slopes = BTreeMap<Source, usize>;
/// Derivatives by the register whose value they belong to.
pub type Taken = BTreeMap<usize, Slopes>;

/// The register of a value, and those of its derivatives by all that it depends on.
#[derive(Debug, Clone)]
pub struct Row {
    /// The value.
    pub value: usize,
    /// The derivatives.
    pub by: Vec<(Source, usize)>,
}

impl Graph {
    /// A value with its derivatives.
    pub fn row(&mut self, register: usize) -> Row {
        Row { value: register, by: self.slopes(register).into_iter().collect() }
    }

    fn slopes(&mut self, register: usize) -> Slopes {
        if let Some(known) = self.taken.get(&register) {
            return known.clone();
        }
        let mut sum = Slopes::new();
        match self.steps[register] {
            // Nothing depends on a derivative but rows.
            Step::Constant(_) | Step::Switch(..) | Step::Slope { .. } => {}
            Step::Source(source) => _ = sum.insert(source, self.constant(1.0)),
            Step::Add(a, b) => {
                sum = self.slopes(a);
                self.adds(&mut sum, b, None);
            }
            Step::Subtract(a, b) => {
                sum = self.slopes(a);
                self.takes(&mut sum, b, None);
            }
            Step::Multiply(a, b) => {
                self.adds(&mut sum, a, Some(b));
                self.adds(&mut sum, b, Some(a));
            }
            Step::Divide(a, b) => {
                let one = self.constant(1.0);
                let inverse = self.push(Step::Divide(one, b));
                self.adds(&mut sum, a, Some(inverse));
                let part = self.push(Step::Multiply(register, inverse));
                self.takes(&mut sum, b, Some(part));
            }
            Step::Apply { of, count, .. } => {
                for (by, argument) in of.into_iter().take(count).enumerate() {
                    if !self.slopes(argument).is_empty() {
                        let slope = self.push(Step::Slope { of: register, by });
                        self.adds(&mut sum, argument, Some(slope));
                    }
                }
            }
        }
        self.taken.insert(register, sum.clone());
        sum
    }

    /// Adds the derivatives of a register, times a factor.
    fn adds(&mut self, sum: &mut Slopes, of: usize, factor: Option<usize>) {
        for (source, slope) in self.times(of, factor) {
            let all = match sum.get(&source) {
                Some(before) => self.push(Step::Add(*before, slope)),
                None => slope,
            };
            sum.insert(source, all);
        }
    }

    /// Subtracts them.
    fn takes(&mut self, sum: &mut Slopes, of: usize, factor: Option<usize>) {
        for (source, slope) in self.times(of, factor) {
            let all = match sum.get(&source) {
                Some(before) => self.push(Step::Subtract(*before, slope)),
                None => self.negative(slope),
            };
            sum.insert(source, all);
        }
    }

    fn times(&mut self, of: usize, factor: Option<usize>) -> Slopes {
        let mut slopes = self.slopes(of);
        if let Some(factor) = factor {
            slopes.values_mut().for_each(|slope| *slope = self.push(Step::Multiply(*slope, factor)));
        }
        slopes
    }
}
