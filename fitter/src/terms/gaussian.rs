//! `gaussian`: exp(−(v − centre)²/(2 width²)); one coefficient, the height. Of the angle, a local defect.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gaussian {
    /// Name of the observable.
    pub observable: String,
    /// Centre, in the unit of the observable.
    pub centre: f64,
    /// Standard deviation, in the unit of the observable.
    pub width: f64,
}

impl Gaussian {
    /// A bump at `centre`.
    pub fn of(observable: &str, centre: f64, width: f64) -> Gaussian {
        Gaussian { observable: observable.to_string(), centre, width }
    }

    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let values = observables.nearest(&self.observable, self.centre)?;
        Ok(values
            .iter()
            .map(|v| {
                let z = (v - self.centre) / self.width;
                libm::exp(-0.5 * z * z)
            })
            .collect())
    }
}
