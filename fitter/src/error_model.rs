//! The angular error model, Eq. 4–6 and 13 of Fan et al., "Improving Angular Accuracy of a Scanning
//! Mirror Based on Error Modeling and Correction" (2019), and its plain counterpart for a sensor that
//! reports the angle or position itself.
//!
//! This is the `f64` reference that every generated routine is held against.

use serde::{Deserialize, Serialize};

/// What turns readings into the angle (or position) whose error is modelled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Sensor {
    /// Two eddy-current probes on either side of the rotation axis (Eq. 1–3): the reading is
    /// s = x₂ − x₁ in millimetres, the angle θ = atan(s/d) in radians.
    EddyCurrentPair {
        /// d, the distance between the axes of the two probes, in millimetres.
        probe_distance_mm: f64,
        /// x₁₀ = x₂₀, the distance of either probe from its pad at rest, in millimetres.
        initial_gap_mm: f64,
    },
    /// A sensor that reports the angle or position itself (encoder, resolver, capacitive head), in `unit`.
    Direct {
        /// The unit of the reading and of its reference, for example `mm` or `deg`.
        unit: String,
        /// One whole turn in `unit`, where the sensor turns round and round.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        revolution: Option<f64>,
    },
}

impl Sensor {
    /// One whole turn in the sensor's unit, where the sensor turns round and round.
    pub fn revolution(&self) -> Option<f64> {
        match self {
            Sensor::Direct { revolution, .. } => *revolution,
            Sensor::EddyCurrentPair { .. } => None,
        }
    }

    /// What it is called in messages.
    #[cfg(feature = "fit")]
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Sensor::EddyCurrentPair { .. } => "an eddy-current pair",
            Sensor::Direct { .. } => "a direct sensor",
        }
    }
}

/// An identified error model: the polynomial of Eq. 5 with what is needed to evaluate Eq. 6 and 13.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorModel {
    /// The sensor and its geometry.
    pub sensor: Sensor,
    /// The reading about which the polynomial is written; 0 for an eddy-current pair (Eq. 5).
    pub centre: f64,
    /// a₀, a₁ − Δd/d, a₂ … aₙ. Pair: of Δs in millimetres as a polynomial of s in millimetres (aᵢ in
    /// mm¹⁻ⁱ). Direct: of the error in the sensor's unit as a polynomial of (reading − centre).
    pub coefficients: Vec<f64>,
}

impl ErrorModel {
    /// The angular error Δθ of Eq. 6 in radians at s in millimetres; for a direct sensor the error of the
    /// reading, in the sensor's unit.
    pub fn error(&self, reading: f64) -> f64 {
        let x = reading - self.centre;
        let polynomial = self.coefficients.iter().rev().fold(0.0, |sum, a| sum * x + a);
        self.sensor.gain(reading) * polynomial
    }

    /// The uncorrected angle θ of Eq. 1 in radians; for a direct sensor the reading itself.
    pub fn uncorrected(&self, reading: f64) -> f64 {
        self.sensor.calculated(reading)
    }

    /// The corrected angle θ − Δθ of Eq. 13 in radians; for a direct sensor the corrected reading in its unit.
    pub fn corrected(&self, reading: f64) -> f64 {
        self.uncorrected(reading) - self.error(reading)
    }
}
