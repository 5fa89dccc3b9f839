//! Geometry of the measurement, Eq. 1–4: from a reading to the calculated angle, and how an error of the
//! reading becomes one of the angle.
//!
//! The arc tangent is that of the `libm` crate, not of the system, so that a fit gives the same bytes on
//! every machine.

use crate::error_model::Sensor;
use crate::units::{ARCSEC_PER_RAD, rad_from_arcsec};

impl Sensor {
    /// Calculated angle θ = atan(s/d) in radians of s in millimetres (Eq. 1); for a direct sensor the reading.
    pub fn calculated(&self, reading: f64) -> f64 {
        match self {
            Sensor::EddyCurrentPair { probe_distance_mm: d, .. } => libm::atan(reading / d),
            Sensor::Direct { .. } => reading,
        }
    }

    /// ∂θ/∂s = d/(s² + d²) in rad/mm (Eq. 4); 1 for a direct sensor.
    pub fn gain(&self, reading: f64) -> f64 {
        match self {
            Sensor::EddyCurrentPair { probe_distance_mm: d, .. } => d / (reading * reading + d * d),
            Sensor::Direct { .. } => 1.0,
        }
    }

    /// A reference reading (arcseconds; direct: the sensor's unit) in the internal unit (radians; direct:
    /// the sensor's unit).
    pub fn internal(&self, reference: f64) -> f64 {
        match self {
            Sensor::EddyCurrentPair { .. } => rad_from_arcsec(reference),
            Sensor::Direct { .. } => reference,
        }
    }

    /// How many of [`Sensor::error_unit`] one internal unit (radian; direct: the sensor's unit) is.
    pub fn per_internal(&self) -> f64 {
        match self {
            Sensor::EddyCurrentPair { .. } => ARCSEC_PER_RAD,
            Sensor::Direct { .. } => 1.0,
        }
    }

    /// The unit in which errors and residuals are reported: `arcsec`, or the direct sensor's.
    pub fn error_unit(&self) -> &str {
        match self {
            Sensor::EddyCurrentPair { .. } => "arcsec",
            Sensor::Direct { unit, .. } => unit,
        }
    }

    /// The variable of the polynomial: `s_mm`, or `measured`.
    pub fn reading_name(&self) -> &'static str {
        match self {
            Sensor::EddyCurrentPair { .. } => "s_mm",
            Sensor::Direct { .. } => "measured",
        }
    }

    /// The unit of that variable: `mm`, or the direct sensor's.
    pub fn reading_unit(&self) -> &str {
        match self {
            Sensor::EddyCurrentPair { .. } => "mm",
            Sensor::Direct { unit, .. } => unit,
        }
    }
}
