//! Values as a graph: what is the same stands once, and what is known at once is computed at once.

use crate::operator::Operator;

/// Most arguments of an operator.
pub const MOST_ARGUMENTS: usize = 4;
/// Largest power that is written as products.
const MOST_PRODUCTS: f64 = 8.0;

/// What values depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// A state, by number.
    State(usize),
    /// An input, by number.
    Input(usize),
    /// A parameter, by number.
    Parameter(usize),
    /// The time in seconds.
    Time,
}

/// How a value follows from others, which are given by their registers.
#[derive(Clone, Copy)]
pub enum Step {
    Constant(f64),
    Source(Source),
    /// The value of a switch, by number: that below and that above.
    Switch(usize, [f64; 2]),
    Add(usize, usize),
    Subtract(usize, usize),
    Multiply(usize, usize),
    Divide(usize, usize),
    Apply {
        operator: &'static dyn Operator,
        of: [usize; MOST_ARGUMENTS],
        count: usize,
    },
    /// The derivative of an applied operator by one of its arguments.
    Slope {
        of: usize,
        by: usize,
    },
}

/// What is known of a step before it is run.
pub enum Known {
    /// Its value.
    Value(f64),
    /// It is the same as another register.
    Same(usize),
    /// Nothing.
    Not,
}

/// Steps, each of which follows from earlier ones.
#[derive(Clone, Default)]
pub struct Graph {
    pub steps: Vec<Step>,
    /// Derivatives that were taken before.
    pub(super) taken: super::slopes::Taken,
}

impl Graph {
    /// The register of a step, which may be an earlier one.
    pub fn push(&mut self, step: Step) -> usize {
        let constant = |k: usize| match self.steps[k] {
            Step::Constant(value) => Some(value),
            _ => None,
        };
        let step = match step.known(&self.steps, constant) {
            Known::Same(register) => return register,
            Known::Value(value) => Step::Constant(value),
            Known::Not => step,
        };
        self.steps.iter().position(|other| same(other, &step)).unwrap_or_else(|| {
            self.steps.push(step);
            self.steps.len() - 1
        })
    }

    /// All that a value follows from, and itself, in order.
    pub fn below(&self, register: usize) -> Vec<usize> {
        let mut held = vec![false; register + 1];
        held[register] = true;
        for k in (0..=register).rev() {
            if held[k] {
                self.steps[k].of().for_each(|of| held[of] = true);
            }
        }
        (0..=register).filter(|k| held[*k]).collect()
    }

    /// The register of a source.
    pub fn source(&mut self, source: Source) -> usize {
        self.push(Step::Source(source))
    }

    /// The register of a number.
    pub fn constant(&mut self, value: f64) -> usize {
        self.push(Step::Constant(value))
    }

    /// The register of −a.
    pub fn negative(&mut self, a: usize) -> usize {
        let zero = self.constant(0.0);
        self.push(Step::Subtract(zero, a))
    }

    /// The register of a number times a.
    pub fn scaled(&mut self, a: usize, factor: f64) -> usize {
        let factor = self.constant(factor);
        self.push(Step::Multiply(factor, a))
    }

    /// The register of a power; one of a small whole number is a product.
    pub fn power(&mut self, operator: &'static dyn Operator, of: [usize; MOST_ARGUMENTS]) -> usize {
        match self.steps[of[1]] {
            Step::Constant(n) if n == n.round() && (1.0..=MOST_PRODUCTS).contains(&n) => {
                (1..n as usize).fold(of[0], |product, _| self.push(Step::Multiply(product, of[0])))
            }
            _ => self.push(Step::Apply { operator, of, count: 2 }),
        }
    }
}

/// Whether two steps give the same value.
fn same(one: &Step, other: &Step) -> bool {
    match (one, other) {
        (Step::Constant(a), Step::Constant(b)) => a.to_bits() == b.to_bits(),
        (Step::Source(a), Step::Source(b)) => a == b,
        (Step::Switch(a, x), Step::Switch(b, y)) => a == b && x == y,
        (Step::Add(a, b), Step::Add(c, d)) | (Step::Multiply(a, b), Step::Multiply(c, d)) => {
            (a, b) == (c, d) || (b, a) == (c, d)
        }
        (Step::Subtract(a, b), Step::Subtract(c, d)) | (Step::Divide(a, b), Step::Divide(c, d)) => {
            (a, b) == (c, d)
        }
        (Step::Apply { operator: p, of: a, count: n }, Step::Apply { operator: q, of: b, count: m }) => {
            p.operation() == q.operation() && n == m && a == b
        }
        (Step::Slope { of: a, by: x }, Step::Slope { of: b, by: y }) => (a, x) == (b, y),
        _ => false,
    }
}

impl Step {
    /// What is known of a step where the values of some registers are known. A factor of zero makes a product zero,
    /// whatever it multiplies.
    pub fn known(&self, steps: &[Step], value: impl Fn(usize) -> Option<f64>) -> Known {
        let is = |k: usize, number: f64| value(k) == Some(number);
        let both = |a: usize, b: usize| value(a).zip(value(b));
        match *self {
            Step::Constant(value) => Known::Value(value),
            Step::Source(_) | Step::Switch(..) => Known::Not,
            Step::Add(a, b) => match both(a, b) {
                Some((a, b)) => Known::Value(a + b),
                None if is(a, 0.0) => Known::Same(b),
                None if is(b, 0.0) => Known::Same(a),
                None => Known::Not,
            },
            Step::Subtract(a, b) => match both(a, b) {
                Some((a, b)) => Known::Value(a - b),
                None if is(b, 0.0) => Known::Same(a),
                None => Known::Not,
            },
            Step::Multiply(a, b) => match both(a, b) {
                Some((a, b)) => Known::Value(a * b),
                None if is(a, 0.0) || is(b, 0.0) => Known::Value(0.0),
                None if is(a, 1.0) => Known::Same(b),
                None if is(b, 1.0) => Known::Same(a),
                None => Known::Not,
            },
            Step::Divide(a, b) => match both(a, b) {
                Some((a, b)) => Known::Value(a / b),
                None if is(b, 1.0) => Known::Same(a),
                None => Known::Not,
            },
            Step::Apply { .. } => self.applied(&value).map_or(Known::Not, |(number, _)| Known::Value(number)),
            Step::Slope { of, by } => {
                steps[of].applied(&value).map_or(Known::Not, |(_, slopes)| Known::Value(slopes[by]))
            }
        }
    }

    /// The value and the derivatives of an applied operator all of whose arguments are known.
    fn applied(&self, value: &impl Fn(usize) -> Option<f64>) -> Option<(f64, [f64; MOST_ARGUMENTS])> {
        let Step::Apply { operator, of, count } = self else { return None };
        let (mut given, mut slopes) = ([0.0; MOST_ARGUMENTS], [0.0; MOST_ARGUMENTS]);
        for (number, register) in given.iter_mut().zip(&of[..*count]) {
            *number = value(*register)?;
        }
        let number = operator.at(&given[..*count], &mut slopes[..*count]);
        Some((number, slopes))
    }

    /// The registers that it follows from.
    pub fn of(&self) -> impl Iterator<Item = usize> {
        let (of, count) = match *self {
            Step::Constant(_) | Step::Source(_) | Step::Switch(..) => ([0; MOST_ARGUMENTS], 0),
            Step::Add(a, b) | Step::Subtract(a, b) | Step::Multiply(a, b) | Step::Divide(a, b) => {
                ([a, b, 0, 0], 2)
            }
            Step::Apply { of, count, .. } => (of, count),
            Step::Slope { of, .. } => ([of, 0, 0, 0], 1),
        };
        of.into_iter().take(count)
    }
}
