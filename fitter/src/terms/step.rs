//! `step`: 0 before `at`, 1 from there on; one coefficient. Of time, a mount that slipped.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Name of the observable, `t_s` for a step in time.
    pub observable: String,
    /// Where it steps, in the unit of the observable.
    pub at: f64,
}

impl Step {
    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let values = observables.get(&self.observable)?;
        Ok(values.iter().map(|v| if v.is_nan() { *v } else { f64::from(u8::from(*v >= self.at)) }).collect())
    }
}
