//! `exponential`: 1 − e^(−(v − start)/scale) for v ≥ start, 0 before; one coefficient. Of time, a warm-up.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exponential {
    /// Name of the observable, `t_s` for a warm-up.
    pub observable: String,
    /// Where it begins, in the unit of the observable.
    pub start: f64,
    /// The time constant, in the unit of the observable.
    pub scale: f64,
}

impl Exponential {
    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let values = observables.get(&self.observable)?;
        Ok(values
            .iter()
            .map(|v| if *v < self.start { 0.0 } else { -libm::expm1(-(v - self.start) / self.scale) })
            .collect())
    }
}
