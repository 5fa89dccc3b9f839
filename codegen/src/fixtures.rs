//! Devices that tests start from.

use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};

/// The device of the paper, Eq. 12.
pub fn paper_model() -> ErrorModel {
    ErrorModel {
        sensor: Sensor::EddyCurrentPair { probe_distance_mm: 12.0, initial_gap_mm: 0.3 },
        centre: 0.0,
        coefficients: vec![-6.15e-5, 0.1439, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4],
    }
}

/// Coefficients of the paper's device over |s| ≤ 0.38 mm.
pub fn paper_coefficients() -> Coefficients {
    Coefficients::of_model(&paper_model(), -0.38, 0.38, "by hand")
}
