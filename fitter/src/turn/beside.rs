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
}
