//! The coefficients file, `coefficients.json`: what `fitter fit` writes, `fitter apply` and `codegen` read.
//!
//! Versioned; numbers survive a round trip exactly; a newer or damaged file is refused in a sentence.

use serde::{Deserialize, Serialize};

use crate::error_model::{ErrorModel, Sensor};

/// The whole file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// Always `arcsmith-coefficients`.
    pub schema: String,
    /// Version of the schema, [`VERSION`] when written by this program.
    pub version: u32,
    /// Program and version that wrote the file.
    pub tool: String,
    /// The command that wrote the file.
    pub command: String,
    /// The recording that was fitted.
    pub recording: Provenance,
    /// The sensor and its geometry.
    pub sensor: Sensor,
    /// The range of readings that the recording covers, inside which the polynomial holds.
    pub valid_range: ValidRange,
    /// The polynomial of the error model.
    pub base: Base,
}

/// Version of the schema that this program writes, and the newest that it reads.
pub const VERSION: u32 = 1;

/// Where the coefficients come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// File name without its folder.
    pub file: String,
    /// SHA-256 of the bytes of the file, in hexadecimal.
    pub sha256: String,
    /// Number of readings.
    pub rows: usize,
    /// Number of passes.
    pub passes: usize,
}

/// The range of readings in which a model holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValidRange {
    /// `s_mm` for an eddy-current pair, `measured` for a direct sensor.
    pub variable: String,
    /// Smallest reading, inclusive.
    pub from: f64,
    /// Largest reading, inclusive.
    pub to: f64,
}

/// The polynomial of Eq. 5 as identified (Eq. 11).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// The order n.
    pub order: usize,
    /// The reading about which the polynomial is written; 0 for an eddy-current pair.
    pub centre: f64,
    /// a₀, a₁ − Δd/d, a₂ … aₙ: see [`ErrorModel::coefficients`].
    pub coefficients: Vec<f64>,
}

impl Coefficients {
    /// The base error model, without the terms of further effects.
    pub fn error_model(&self) -> ErrorModel {
        ErrorModel {
            sensor: self.sensor.clone(),
            centre: self.base.centre,
            coefficients: self.base.coefficients.clone(),
        }
    }
}
