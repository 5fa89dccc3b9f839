//! `hinge`: how far an observable lies beyond a threshold, 0 on the other side; one coefficient, the slope
//! there. Of the angle, a sensor that clips.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// Which side of the threshold has the slope.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// max(0, v − threshold).
    Above,
    /// max(0, threshold − v).
    Below,
}

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hinge {
    /// Name of the observable.
    pub observable: String,
    /// In the unit of the observable.
    pub threshold: f64,
    /// The side that has the slope.
    pub side: Side,
}

impl Hinge {
    /// A slope on one side of `threshold`.
    pub fn of(observable: &str, threshold: f64, side: Side) -> Hinge {
        Hinge { observable: observable.to_string(), threshold, side }
    }

    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let values = observables.get(&self.observable)?;
        let beyond = |v: f64| match self.side {
            Side::Above => v - self.threshold,
            Side::Below => self.threshold - v,
        };
        // Written so that a blank stays a blank, which `max` would turn into 0.
        Ok(values.iter().map(|v| if beyond(*v) < 0.0 { 0.0 } else { beyond(*v) }).collect())
    }
}
