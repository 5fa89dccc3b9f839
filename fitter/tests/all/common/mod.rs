//! Recordings of known devices, for tests: a polynomial of Eq. 5, white noise, and whatever is added.

#![allow(dead_code)] // each test binary uses its part

pub mod encoder;

use std::fmt::Write;

use fitter::coefficients::Reference;
use fitter::{Mirror, Recording, Sensor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Probe distance of the paper in millimetres.
pub const D_MM: f64 = 12.0;
/// Eq. 12: a₀, a₁ − Δd/d, a₂ … a₉ in mm and rad.
pub const PAPER: [f64; 10] = [-6.15e-5, 0.14, -0.039, 0.14, 0.18, -0.86, -1.21, 5.58, 2.88, -12.4];
const ARCSEC: f64 = 206_264.806_247_096_36;

/// A calibration to simulate.
pub struct Device<'a> {
    pub polynomial: &'a [f64],
    pub noise_arcsec: f64,
    pub passes: usize,
    /// Commanded angles in degrees.
    pub angles: Vec<f64>,
    /// Added to the angular error in arcsec; given (t_s, direction, temperature_c, angle_deg).
    pub extra: fn(f64, f64, f64, f64) -> f64,
    pub commanded: bool,
}

impl Device<'_> {
    pub fn paper() -> Device<'static> {
        Device {
            polynomial: &PAPER,
            noise_arcsec: 0.5,
            passes: 6,
            angles: (-17..=17).map(|step| 0.1 * f64::from(step)).collect(),
            extra: |_, _, _, _| 0.0,
            commanded: true,
        }
    }

    /// The recording as CSV.
    pub fn csv(&self, seed: u64) -> String {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut text = String::from("t_s,pass,direction,");
        text += if self.commanded { "command_deg," } else { "" };
        text += "x1_mm,x2_mm,reference_arcsec,temperature_c\n";
        let alpha0 = 50.0 * normal(&mut random);
        let mut time = 0.0;
        for pass in 0..self.passes {
            let forward = pass % 2 == 0;
            let mut angles = self.angles.clone();
            if !forward {
                angles.reverse();
            }
            for angle in angles {
                time += 2.7;
                let s = D_MM * angle.to_radians().tan() + 1e-7 * normal(&mut random);
                let polynomial = self.polynomial.iter().rev().fold(0.0, |sum, a| sum * s + a);
                let error_rad = D_MM / (s * s + D_MM * D_MM) * polynomial;
                let temperature = 27.0 + 0.3 * normal(&mut random);
                let direction = if forward { 1.0 } else { -1.0 };
                let reference = ((s / D_MM).atan() - error_rad) * ARCSEC
                    - (self.extra)(time, direction, temperature, angle)
                    + alpha0
                    + self.noise_arcsec * normal(&mut random);
                write!(text, "{time:.2},{pass},{direction},").unwrap();
                if self.commanded {
                    write!(text, "{angle:.3},").unwrap();
                }
                let (x1, x2) = (0.001 - s / 2.0, 0.001 + s / 2.0);
                writeln!(text, "{x1:.9},{x2:.9},{reference:.5},{temperature:.3}").unwrap();
            }
        }
        text
    }

    pub fn recording(&self, seed: u64) -> Recording {
        Recording::from_bytes("simulated.csv", self.csv(seed).as_bytes()).unwrap()
    }
}

pub fn mirror() -> Mirror {
    Mirror::paper()
}

pub fn direct(unit: &str) -> Mirror {
    let sensor = Sensor::Direct { unit: unit.to_string(), revolution: None };
    Mirror { sensor, reference: Reference::default() }
}

/// Standard normal (Box & Muller).
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    let uniform = |word: u64| (word >> 11) as f64 / (1u64 << 53) as f64;
    let (u, v) = (1.0 - uniform(random.next_u64()), uniform(random.next_u64()));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

pub fn arcsec(angle_rad: f64) -> f64 {
    angle_rad * ARCSEC
}
