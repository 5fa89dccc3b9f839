//! A device: one mirror with its probes and drive, drawn from a seed, in front of an autocollimator.

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::angular_error::AngularError;
use crate::autocollimator::Autocollimator;
use crate::drive::Drive;
use crate::environment::SecondAxis;
use crate::geometry::Geometry;
use crate::probes::ProbePair;
use crate::streams::{Stream, stream};

/// One mirror on its bench.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// Where the probes sit.
    pub geometry: Geometry,
    /// The two probes.
    pub probes: ProbePair,
    /// Flexure and voice coils.
    pub drive: Drive,
    /// How the second axis goes with the deflection.
    pub second_axis: SecondAxis,
    /// Translation of the plate with temperature, in mm/K.
    pub plate_mm_per_k: f64,
    /// The reference instrument.
    pub autocollimator: Autocollimator,
}

impl Device {
    /// The device of `seed`: its angular error in pure rotation is always that of Eq. 12; how the two
    /// probes share it, their nonlinearities in common, drive and alignment are its own.
    pub fn from_seed(seed: u64) -> Self {
        let mut generator = stream(seed, Stream::Device);
        Self {
            geometry: Geometry::default(),
            probes: ProbePair::draw(AngularError::paper(), &mut generator),
            drive: Drive::draw(&mut generator),
            second_axis: SecondAxis::draw(&mut generator),
            plate_mm_per_k: 0.02e-3 * generator.sample::<f64, _>(StandardNormal),
            autocollimator: Autocollimator::default(),
        }
    }

    /// What the probes report without noise, x₁ and x₂ in millimetres, at a true angle in radians and a
    /// translation of the plate in millimetres.
    pub fn report_mm(&self, true_angle_rad: f64, translation_mm: f64) -> [f64; 2] {
        let distances = self.geometry.pad_distances_mm(true_angle_rad, translation_mm);
        self.probes.report_mm(distances, &self.geometry)
    }
}
