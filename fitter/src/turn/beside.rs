//! What is fitted beside the harmonics because the angle alone does not tell it: direction, speed, a slope over the turn.

use super::significance::Tested;

/// Which of them a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// +1 forward, −1 backward.
    Direction,
    /// The rate of the reading: its coefficient is less the lag.
    Velocity,
    /// The reading as it travelled, from the middle of the recorded turn.
    Slope,
}

/// A column.
#[derive(Debug, Clone)]
pub(super) struct Beside {
    pub kind: Kind,
    pub values: Vec<f64>,
    /// What the column is divided by, to be of about the length of the others.
    pub length: f64,
    /// How sure its coefficient is, where that was tested.
    pub tested: Option<Tested>,
}

impl Beside {
    pub fn direction(direction: &[i8]) -> Beside {
        let values = direction.iter().map(|direction| f64::from(*direction)).collect();
        Beside { kind: Kind::Direction, values, length: 1.0, tested: None }
    }

    /// A column of any length.
    pub fn of(kind: Kind, values: Vec<f64>) -> Beside {
        let length = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        Beside { kind, values, length, tested: None }
    }

    /// Whether two columns are one, up to a factor and a constant: an axis that stands in one direction and turns at one
    /// speed in the other.
    pub fn like(&self, other: &Beside) -> bool {
        let rows = self.values.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / rows;
        let (a, b) = (mean(&self.values), mean(&other.values));
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
        for (x, y) in self.values.iter().zip(&other.values) {
            (aa, ab, bb) = (aa + (x - a) * (x - a), ab + (x - a) * (y - b), bb + (y - b) * (y - b));
        }
        ab * ab > ALIKE * aa * bb
    }
}

/// Squared correlation from which on two columns are one: the rest would be told from a thousandth of their length.
const ALIKE: f64 = 1.0 - 1e-6;
