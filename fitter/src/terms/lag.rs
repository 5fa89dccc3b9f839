//! `lag`: a first-order lag of an observable, one coefficient: v_L − mean with τ dv_L/dt = v − v_L.
//!
//! Between two rows v is taken as a straight line, for which the lag has a closed form:
//! v_L' = a v_L + (1 − a) v + (v' − v)(1 − (1 − a) τ/Δt), a = e^(−Δt/τ).

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lag {
    /// Name of the observable.
    pub observable: String,
    /// τ in seconds.
    pub time_constant_s: f64,
    /// The observable's mean in the recording that was diagnosed.
    pub mean: f64,
    /// v_L at the first row; the first row's v where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial: Option<f64>,
}

impl Lag {
    /// A lag that starts at the first row's value.
    pub fn of(observable: &str, time_constant_s: f64, mean: f64) -> Lag {
        Lag { observable: observable.to_string(), time_constant_s, mean, initial: None }
    }

    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let values = observables.get(&self.observable)?;
        let lagged = self.lagged(&observables.recording.time_s, &values);
        Ok(lagged.into_iter().map(|v| v - self.mean).collect())
    }

    /// v_L over the rows. Where v is blank the last known one stands; where time runs backward nothing
    /// passes.
    pub fn lagged(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let first = values.iter().copied().find(|v| !v.is_nan()).unwrap_or(f64::NAN);
        let mut state = self.initial.unwrap_or(first);
        let mut before = first;
        let mut time = time_s.first().copied().unwrap_or(0.0);
        (time_s.iter().zip(values))
            .map(|(t, v)| {
                let v = if v.is_nan() { before } else { *v };
                let passed = (t - time).max(0.0);
                if passed > 0.0 {
                    let ratio = passed / self.time_constant_s;
                    // 1 − e^(−x) without cancellation.
                    let gone = -libm::expm1(-ratio);
                    state += gone * (before - state) + (v - before) * (1.0 - gone / ratio);
                }
                (before, time) = (v, *t);
                state
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a ramp the lag trails by slope·τ in the end, and it does not depend on how finely it is sampled.
    #[test]
    fn is_exact_on_a_ramp() {
        let lag = Lag::of("temperature_c", 10.0, 0.0);
        let fine: Vec<f64> = (0..=1000).map(|i| 0.1 * f64::from(i)).collect();
        let coarse: Vec<f64> = (0..=4).map(|i| 25.0 * f64::from(i)).collect();
        let (a, b) = (lag.lagged(&fine, &fine), lag.lagged(&coarse, &coarse));
        approx::assert_abs_diff_eq!(a[1000], b[4], epsilon = 1e-10);
        let expected = 100.0 - 10.0 * (1.0 - (-10.0f64).exp());
        approx::assert_abs_diff_eq!(b[4], expected, epsilon = 1e-10);
    }
}
