//! The drive: a flexure that a pair of voice coils bends, so that the current follows the deflection.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// Flexure and voice coils.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Current per deflection, in A/rad.
    pub stiffness_a_per_rad: f64,
    /// Current at rest, in A.
    pub offset_a: f64,
    /// Standard deviation of the slow creep of the flexure, in A.
    pub creep_a: f64,
    /// Standard deviation of the current from one settled position to the next, by friction, in A.
    pub settling_a: f64,
    /// Standard deviation of the current reading, in A.
    pub noise_a: f64,
    /// The mirror rests against a stop at this angle, in radians.
    pub stop_rad: f64,
}

impl Drive {
    /// Draws a drive: about 0.065 A per degree.
    pub fn draw(generator: &mut impl Rng) -> Self {
        let mut normal = || generator.sample::<f64, _>(StandardNormal);
        Self {
            stiffness_a_per_rad: 0.065 * (1.0 + 0.03 * normal()) / 1f64.to_radians(),
            offset_a: 0.003 * normal(),
            creep_a: 0.005,
            settling_a: 0.001,
            noise_a: 1e-4,
            stop_rad: 1.8f64.to_radians(),
        }
    }
}
