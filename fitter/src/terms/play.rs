//! `play`: v − play_r(v) of an observable v, one coefficient per element.
//!
//! The play operator (Krasnosel'skii & Pokrovskii 1989) follows v at a distance of at most r:
//! p ← max(v − r, min(v + r, p)). One element is backlash; several of different half-widths, a
//! distributed play (Prandtl–Ishlinskii), are hysteresis.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Play {
    /// Name of the observable.
    pub observable: String,
    /// One column each.
    pub elements: Vec<Element>,
}

/// One play operator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Element {
    /// r, in the unit of the observable.
    pub half_width: f64,
    /// The operator's value before the first row; the first row's v where not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial: Option<f64>,
}

impl Play {
    /// Plays of the given half-widths, each starting at the first row's value.
    pub fn of(observable: &str, half_widths: &[f64]) -> Play {
        let elements = half_widths.iter().map(|r| Element { half_width: *r, initial: None }).collect();
        Play { observable: observable.to_string(), elements }
    }

    pub(super) fn columns(&self, observables: &Observables) -> Result<Vec<Vec<f64>>, Missing> {
        let values = observables.get(&self.observable)?;
        Ok(self.elements.iter().map(|element| element.column(&values)).collect())
    }
}

impl Element {
    /// v − play_r(v) over the values, in their order; a blank leaves the state as it is.
    pub fn column(&self, values: &[f64]) -> Vec<f64> {
        let mut state = self.initial.or(values.iter().copied().find(|v| !v.is_nan())).unwrap_or(0.0);
        (values.iter())
            .map(|v| {
                if !v.is_nan() {
                    state = state.clamp(v - self.half_width, v + self.half_width);
                }
                v - state
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_at_a_distance_and_remembers_the_direction() {
        let element = Element { half_width: 1.0, initial: None };
        assert_eq!(element.column(&[0.0, 0.5, 3.0, 2.5, 0.0]), [0.0, 0.5, 1.0, 0.5, -1.0]);
        let element = Element { half_width: 1.0, initial: Some(-1.0) };
        assert_eq!(element.column(&[0.0, 0.5]), [1.0, 1.0]);
    }
}
