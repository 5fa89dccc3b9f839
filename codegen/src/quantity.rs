//! What a routine computes, in words and units: the angle of a pair of probes, or a direct sensor's reading.

use fitter::error_model::{ErrorModel, Sensor};
use fitter::units::ARCSEC_PER_RAD;

/// The bound of a mirror's angle unless another is named, far below what any autocollimator tells.
const MIRROR_ARCSEC: f64 = 0.01;
/// The bound of a direct sensor's reading, as a part of its noise: it adds 0.005 % to it.
const OF_THE_NOISE: f64 = 0.01;
/// A bound so many times larger is a tenth of the noise, and adds half a per cent to it.
const STILL_TAKEN: f64 = 10.0;
/// The bound as a part of the range, where the noise is not known.
const OF_THE_RANGE: f64 = 1e-6;

/// Names and units of what is computed.
#[derive(Debug, Clone, PartialEq)]
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

    /// The bound that is asked for where the user names none: 0.01″ of a mirror's angle; of a direct sensor a hundredth
    /// of a reading's noise, or where that is not known a millionth of the range.
    pub fn default_bound(&self, from: f64, to: f64, noise: Option<f64>) -> f64 {
        match noise {
            _ if self.is_angle_of_probes() => MIRROR_ARCSEC,
            Some(noise) => OF_THE_NOISE * noise,
            None => OF_THE_RANGE * (to - from),
        }
    }

    /// The bound that is still taken where none was named and no routine reaches [`Quantity::default_bound`].
    pub fn largest_default_bound(&self, from: f64, to: f64, noise: Option<f64>) -> f64 {
        let usual = self.default_bound(from, to, noise);
        if self.is_angle_of_probes() || noise.is_none() { usual } else { STILL_TAKEN * usual }
    }

    /// Whether the result is the angle of a pair of probes, in radians, its bound in arcseconds.
    fn is_angle_of_probes(&self) -> bool {
        self.unit != self.bound_unit
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
