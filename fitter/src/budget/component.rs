//! One row of a budget.

use serde::{Deserialize, Serialize};

use super::rounded;

/// How a standard uncertainty was found (GUM 4.2, 4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Evaluation {
    /// By the statistics of observations.
    A,
    /// Otherwise: from a data sheet, a certificate, a proof.
    B,
}

/// What is assumed of the values that are possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// Normal; of a standard deviation that is itself estimated, Student's t.
    Normal,
    /// Anything between two limits alike (GUM 4.3.7).
    Rectangular,
    /// The sum of two that are rectangular and alike: ±half the width of both (GUM 4.3.9).
    Triangular,
    /// One of two values, each as often as the other.
    TwoValued,
}

impl Distribution {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Distribution::Normal => "normal",
            Distribution::Rectangular => "rectangular",
            Distribution::Triangular => "triangular",
            Distribution::TwoValued => "two-valued",
        }
    }
}

/// One contribution to the uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Its name for machines: `reference`, `repeatability` ….
    pub source: String,
    /// What it is.
    pub what: String,
    /// How it was evaluated.
    pub evaluation: Evaluation,
    /// The value that was found or stated, in `unit`: a standard deviation, a half-width, an expanded uncertainty.
    pub value: f64,
    /// Unit of `value` and `standard_uncertainty`.
    pub unit: String,
    /// The distribution of the values.
    pub distribution: Distribution,
    /// What `value` is divided by to be a standard uncertainty.
    pub divisor: f64,
    /// u(xᵢ), in `unit`.
    pub standard_uncertainty: f64,
    /// cᵢ, by how much the corrected reading changes with the quantity.
    pub sensitivity: f64,
    /// |cᵢ|·u(xᵢ), in the unit of the budget.
    pub contribution: f64,
    /// Degrees of freedom; none where they are infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
}

impl Component {
    /// A standard deviation of so many degrees of freedom that observations showed, in the budget's unit.
    pub fn observed(source: &str, what: &str, unit: &str, deviation: f64, freedom: f64) -> Component {
        let degrees_of_freedom = Some(rounded(freedom)).filter(|freedom| freedom.is_finite());
        let found = Component::of(source, what, unit, deviation, Distribution::Normal, 1.0);
        Component { evaluation: Evaluation::A, degrees_of_freedom, ..found }
    }

    /// What lies within ±`half`, wherever.
    pub fn within(source: &str, what: &str, unit: &str, half: f64) -> Component {
        Component::of(source, what, unit, half, Distribution::Rectangular, 3f64.sqrt())
    }

    /// What was stated otherwise: a value that `divisor` makes a standard uncertainty, in the budget's unit.
    pub fn of(
        source: &str,
        what: &str,
        unit: &str,
        value: f64,
        distribution: Distribution,
        divisor: f64,
    ) -> Component {
        Component {
            source: source.into(),
            what: what.into(),
            evaluation: Evaluation::B,
            value: rounded(value),
            unit: unit.into(),
            distribution,
            divisor: rounded(divisor),
            standard_uncertainty: rounded(value / divisor),
            sensitivity: 1.0,
            contribution: rounded(value / divisor),
            degrees_of_freedom: None,
        }
    }

    /// With the sensitivity of the corrected reading, in the budget's unit for one unit of the value.
    #[must_use]
    pub fn times(self, sensitivity: f64) -> Component {
        let contribution = rounded(sensitivity.abs() * self.standard_uncertainty);
        Component { sensitivity: rounded(sensitivity), contribution, ..self }
    }
}
