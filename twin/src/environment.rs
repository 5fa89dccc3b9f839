//! The laboratory around the mirror: temperature, the slow translation of the plate and the second axis.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha12Rng;
use rand_distr::StandardNormal;

use crate::noise::Wander;
use crate::temperature::{Course, Temperature};

/// Mean temperature of the laboratory in °C.
pub const LABORATORY_C: f64 = 27.0;

/// What surrounds one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// Time of the reading in seconds.
    pub t_s: f64,
    /// Temperature of the base plate in °C.
    pub temperature_c: f64,
    /// Common-mode translation of the plate in millimetres.
    pub translation_mm: f64,
    /// Slow rotation about the second axis in arcseconds, beside what the deflection itself brings.
    pub cross_arcsec: f64,
    /// Slow change of the coil current in A per A of the drive's creep.
    pub creep: f64,
}

impl Default for Surroundings {
    /// A laboratory in which nothing moves.
    fn default() -> Self {
        Self { t_s: 0.0, temperature_c: LABORATORY_C, translation_mm: 0.0, cross_arcsec: 0.0, creep: 0.0 }
    }
}

/// The course of the surroundings over one recording.
pub struct Environment {
    generator: ChaCha12Rng,
    temperature: Course,
    translation: Wander,
    cross: Wander,
    creep: Wander,
    plate_mm_per_k: f64,
}

impl Environment {
    /// The surroundings of a recording that takes `duration_s`; `plate_mm_per_k` is the translation of the
    /// plate with temperature.
    pub fn start(
        kind: &Temperature,
        duration_s: f64,
        plate_mm_per_k: f64,
        mut generator: ChaCha12Rng,
    ) -> Self {
        let temperature = Course::start(kind, duration_s, &mut generator);
        // 0.2 µm: table, clamping and plate, in minutes.
        let translation = Wander::start(0.2e-3, 300.0, &mut generator);
        let cross = Wander::start(0.8, 600.0, &mut generator);
        let creep = Wander::start(1.0, 500.0, &mut generator);
        Self { generator, temperature, translation, cross, creep, plate_mm_per_k }
    }

    /// The surroundings at `t_s`, which must not lie before the last time asked for.
    pub fn at(&mut self, t_s: f64) -> Surroundings {
        let temperature_c = self.temperature.at(t_s, &mut self.generator);
        let translation_mm = self.translation.at(t_s, &mut self.generator);
        Surroundings {
            t_s,
            temperature_c,
            translation_mm: translation_mm + self.plate_mm_per_k * (temperature_c - LABORATORY_C),
            cross_arcsec: self.cross.at(t_s, &mut self.generator),
            creep: self.creep.at(t_s, &mut self.generator),
        }
    }
}

/// How the second axis goes with the deflection: a tilt of the axes and a little bending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondAxis {
    /// Arcseconds per radian of deflection.
    pub tilt_arcsec_per_rad: f64,
    /// Arcseconds per square radian of deflection.
    pub bend_arcsec_per_rad2: f64,
    /// Standard deviation in arcseconds from one settled position to the next: the flexure never comes to
    /// rest quite the same way.
    pub settling_arcsec: f64,
}

impl SecondAxis {
    /// Draws an alignment that keeps the second axis below 10″ from edge to edge, as the paper demands.
    pub fn draw(generator: &mut impl Rng) -> Self {
        let edge_rad = 1.5f64.to_radians();
        let mut normal = || generator.sample::<f64, _>(StandardNormal).clamp(-2.0, 2.0);
        Self {
            tilt_arcsec_per_rad: 1.2 * normal() / edge_rad,
            bend_arcsec_per_rad2: 0.5 * normal() / (edge_rad * edge_rad),
            settling_arcsec: 0.3,
        }
    }

    /// Rotation about the second axis in arcseconds at the true angle.
    pub fn at(&self, true_angle_rad: f64) -> f64 {
        true_angle_rad * (self.tilt_arcsec_per_rad + true_angle_rad * self.bend_arcsec_per_rad2)
    }
}
