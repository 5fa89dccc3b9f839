//! `product`: Π (observable − mean)^power, one coefficient.
//!
//! Zero drift with temperature is one factor, gain drift two (temperature and angle), leakage of the common
//! mode, the second axis or the coil current one.

use serde::{Deserialize, Serialize};

use super::{Missing, Observables};

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Product {
    /// The factors, one at least.
    pub factors: Vec<Factor>,
}

/// (observable − mean)^power.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// Name of the observable.
    pub observable: String,
    /// Its mean in the recording that was diagnosed, or another reference; 0 for a plain power.
    pub mean: f64,
    /// The power, 1 at least.
    pub power: u8,
}

impl Product {
    /// (observable − mean).
    pub fn of(observable: &str, mean: f64) -> Product {
        Product { factors: vec![Factor { observable: observable.to_string(), mean, power: 1 }] }
    }

    /// This product times (observable − mean)^power.
    pub fn times(mut self, observable: &str, mean: f64, power: u8) -> Product {
        self.factors.push(Factor { observable: observable.to_string(), mean, power });
        self
    }

    pub(super) fn column(&self, observables: &Observables) -> Result<Vec<f64>, Missing> {
        let mut column = vec![1.0; observables.recording.rows()];
        for factor in &self.factors {
            let values = observables.about(&factor.observable, factor.mean)?;
            for (product, value) in column.iter_mut().zip(values.iter()) {
                *product *= (value - factor.mean).powi(i32::from(factor.power));
            }
        }
        Ok(column)
    }

    pub(super) fn contradiction(&self) -> Option<String> {
        if self.factors.is_empty() {
            return Some("a `product` term has no factor".to_string());
        }
        (self.factors.iter()).find(|factor| factor.power == 0 || !factor.mean.is_finite()).map(|factor| {
            format!("factor `{}` of a `product` term has power 0 or no mean", factor.observable)
        })
    }
}
