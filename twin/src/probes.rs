//! The pair of eddy-current probes: each has a characteristic of its own, and together they report the
//! difference s that makes the angular error of the device.
//!
//! With q the displacement of pad 2 in pure rotation (and −q that of pad 1), the pair must report
//! x₂(q) − x₁(−q) = s(Θ), hence the deviations from the true displacement must differ by
//! E(q) = s(Θ) − 2q. Probe 2 carries the share w of it and probe 1 the rest; what both carry in common,
//! h, cancels in pure rotation and shows as soon as the plate translates:
//!
//! x₂ = X + w·E(X) + h(X),  x₁ = X − (1 − w)·E(−X) + h(−X).
//!
//! A translation u therefore leaks into s by about [(2w − 1)·E′(q) + 2h′(q)]·u: gain mismatch and
//! nonlinearity of the probes are what makes the differential method imperfect.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use crate::angular_error::AngularError;
use crate::geometry::Geometry;

/// Displacement in millimetres at which the common nonlinearities are scaled, about the end of the stroke.
const STROKE_MM: f64 = 0.18;

/// Two probes with characteristics of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbePair {
    /// The angular error that the pair has in pure rotation.
    pub error: AngularError,
    /// w, the share of the deviation that probe 2 carries; 0.5 for equal gains.
    pub share: f64,
    /// Coefficients of h in millimetres, of the powers 1, 2, … of X/0.18 mm.
    pub in_common_mm: Vec<f64>,
    /// Standard deviation of the repeatability of one probe, in millimetres.
    pub repeatability_mm: f64,
}

impl ProbePair {
    /// Draws the two characteristics. Gains agree to about 1 %, nonlinearities to about 0.1 µm in each
    /// power: the probes are of one make, adjusted on one material.
    pub fn draw(error: AngularError, generator: &mut impl Rng) -> Self {
        let mut normal = || generator.sample::<f64, _>(StandardNormal);
        let share = 0.5 + 0.005 * normal();
        // The linear term is the gain: 0.2 % of the stroke.
        let mut in_common_mm = vec![0.002 * STROKE_MM * normal()];
        in_common_mm.extend((2..=5).map(|_| 1e-4 * normal()));
        Self {
            error,
            share,
            in_common_mm,
            // The repeatability of 0.05 µm is a limit, three standard deviations.
            repeatability_mm: 0.05e-3 / 3.0,
        }
    }

    /// What the probes report without noise, x₁ and x₂ in millimetres, for the distances x₁₁ and x₂₁ of
    /// the pads in millimetres.
    pub fn report_mm(&self, distances_mm: [f64; 2], geometry: &Geometry) -> [f64; 2] {
        let [x1, x2] = distances_mm.map(|distance| distance - geometry.initial_gap_mm);
        [
            x1 - (1.0 - self.share) * self.difference_mm(-x1) + self.common_mm(-x1),
            x2 + self.share * self.difference_mm(x2) + self.common_mm(x2),
        ]
    }

    /// E(q) in millimetres.
    fn difference_mm(&self, displacement_mm: f64) -> f64 {
        let angle_rad = (2.0 * displacement_mm / self.error.probe_distance_mm).atan();
        self.error.reported_s_mm(angle_rad) - 2.0 * displacement_mm
    }

    /// h(X) in millimetres.
    fn common_mm(&self, displacement_mm: f64) -> f64 {
        let x = displacement_mm / STROKE_MM;
        x * self.in_common_mm.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }
}
