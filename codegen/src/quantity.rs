//! What a routine computes, in words and units: the angle of a pair of probes, or a direct sensor's reading.

use fitter::error_model::{ErrorModel, Sensor};
use fitter::units::ARCSEC_PER_RAD;
use serde::Serialize;

/// Names and units of what is computed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// For headings.
    pub title: String,
    /// The symbol of the exact result.
    pub symbol: String,
    /// The formula with its numbers.
    pub formula: String,
    /// Symbol of the reading.
    pub reading: String,
    /// Unit of the reading.
    pub reading_unit: String,
    /// Unit of the result.
    pub unit: String,
    /// Unit in which bounds are stated.
    pub bound_unit: String,
    /// Bound units in one unit of the result.
    #[serde(skip)]
    pub bound_units_per_unit: f64,
    /// The name that a routine gets unless told otherwise.
    pub default_name: String,
}

impl Quantity {
    /// What `model` computes.
    pub fn of(model: &ErrorModel) -> Self {
        let terms = |variable: &str| {
            let terms = model.coefficients.iter().enumerate().map(|(k, a)| match k {
                0 => format!("{a:?}"),
                1 => format!("{a:+?}·{variable}"),
                _ => format!("{a:+?}·{variable}^{k}"),
            });
            terms.collect::<Vec<_>>().join(" ")
        };
        match &model.sensor {
            Sensor::EddyCurrentPair { probe_distance_mm, .. } => Quantity {
                title: "Corrected angle, Eq. 13".into(),
                symbol: "(θ − Δθ)".into(),
                formula: format!(
                    "θ − Δθ = atan(s/d) − d/(s² + d²)·Δs(s), in rad, with d = {probe_distance_mm:?} mm and\nΔs = {}, s in mm",
                    terms("s")
                ),
                reading: "s".into(),
                reading_unit: "mm".into(),
                unit: "rad".into(),
                bound_unit: "arcsec".into(),
                bound_units_per_unit: ARCSEC_PER_RAD.next_up(),
                default_name: "corrected_angle".into(),
            },
            Sensor::Direct { unit, .. } => Quantity {
                title: format!("Corrected reading in {unit}"),
                symbol: "(m − Δm)".into(),
                formula: format!(
                    "m − Δm, the reading less its error, in {unit}, with\nΔm = {}, x = m − {:?}",
                    terms("x"),
                    model.centre
                ),
                reading: "m".into(),
                reading_unit: unit.clone(),
                unit: unit.clone(),
                bound_unit: unit.clone(),
                bound_units_per_unit: 1.0,
                default_name: format!("corrected_{}", unit.to_lowercase()),
            },
        }
    }

    /// The bound that is asked for where the user names none: 0.01″, or a millionth of the range of a length.
    pub fn default_bound(&self, from: f64, to: f64) -> f64 {
        const ARCSEC: f64 = 0.01;
        match self.bound_unit.as_str() {
            "arcsec" => ARCSEC,
            "deg" => ARCSEC / 3600.0,
            "rad" => ARCSEC / ARCSEC_PER_RAD,
            _ => 1e-6 * (to - from),
        }
    }

    /// A length of the result's unit in the bound's unit, rounded up.
    pub fn in_bound_unit(&self, value: f64) -> f64 {
        if value == 0.0 || self.bound_units_per_unit == 1.0 {
            value
        } else {
            (value * self.bound_units_per_unit).next_up()
        }
    }
}
