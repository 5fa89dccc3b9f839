//! A device: one mirror with its probes and drive, drawn from a seed, in front of an autocollimator, with
//! whatever effects are hidden in it.

use std::sync::Arc;

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::angular_error::AngularError;
use crate::autocollimator::Autocollimator;
use crate::drive::Drive;
use crate::effects::{EffectError, Injected, Mechanism};
use crate::environment::SecondAxis;
use crate::geometry::Geometry;
use crate::probes::ProbePair;
use crate::streams::{Stream, stream};
use crate::units::arcsec_from_rad;

/// The calculated angle at either end of the stroke in degrees, as far as the device is calibrated.
pub const STROKE_DEG: f64 = 1.7;

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
    hidden: Vec<Hidden>,
}

/// An effect in a device: what was asked for, and the mechanism that it became.
#[derive(Clone)]
struct Hidden {
    injected: Injected,
    mechanism: Arc<dyn Mechanism>,
}

impl std::fmt::Debug for Hidden {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.injected.fmt(f)
    }
}

impl PartialEq for Hidden {
    fn eq(&self, other: &Self) -> bool {
        self.injected == other.injected
    }
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
            hidden: Vec::new(),
        }
    }

    /// The same device with the mismatch of its two probes multiplied by `factor`; 0 matches them perfectly.
    ///
    /// As drawn, a device leaks up to 0.1″ (rms) of the plate's translation into the angle in a climatic
    /// chamber: honest, but an effect, where a recording is meant to hold none. To be called before
    /// [`with_effects`](Self::with_effects).
    pub fn with_mismatch(&self, factor: f64) -> Self {
        let mut device = self.clone();
        device.probes.share = 0.5 + factor * (self.probes.share - 0.5);
        device.probes.in_common_mm.iter_mut().for_each(|c| *c *= factor);
        device
    }

    /// The same device with these effects hidden in it, in place of any others.
    ///
    /// # Errors
    /// An id or a parameter that is not known, missing, or makes no sense.
    pub fn with_effects(&self, effects: Vec<Injected>) -> Result<Self, EffectError> {
        let mut device = self.clone();
        device.hidden = effects
            .into_iter()
            .map(|injected| Ok(Hidden { mechanism: Arc::from(injected.build(&device)?), injected }))
            .collect::<Result<_, _>>()?;
        Ok(device)
    }

    /// The same device without the effect at `index`.
    pub fn without(&self, index: usize) -> Self {
        let mut device = self.clone();
        device.hidden.remove(index);
        device
    }

    /// The effects that are hidden in the device.
    pub fn effects(&self) -> impl ExactSizeIterator<Item = &Injected> {
        self.hidden.iter().map(|hidden| &hidden.injected)
    }

    /// Their mechanisms, as before a recording.
    pub(crate) fn mechanisms(&self) -> Vec<Box<dyn Mechanism>> {
        self.hidden.iter().map(|hidden| hidden.mechanism.afresh()).collect()
    }

    /// What the probes report without noise and effects, x₁ and x₂ in millimetres, at a true angle in
    /// radians and a translation of the plate in millimetres.
    pub fn report_mm(&self, true_angle_rad: f64, translation_mm: f64) -> [f64; 2] {
        let distances = self.geometry.pad_distances_mm(true_angle_rad, translation_mm);
        self.probes.report_mm(distances, &self.geometry)
    }

    /// The true angles at the two ends of the stroke in radians.
    pub fn stroke_rad(&self) -> [f64; 2] {
        [-STROKE_DEG, STROKE_DEG].map(|deg| self.probes.error.true_angle_rad(self.s_mm(deg.to_radians())))
    }

    /// How far the mirror turns per calculated angle, the least-squares slope over the stroke.
    pub fn true_per_calculated(&self) -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        for theta in stroke_points() {
            product += theta * self.probes.error.true_angle_rad(self.s_mm(theta));
            square += theta * theta;
        }
        product / square
    }

    /// dΘ/dθ at the reported difference s in millimetres.
    pub fn true_per_calculated_at(&self, s_mm: f64) -> f64 {
        let d = self.geometry.probe_distance_mm;
        self.probes.error.slope_rad_per_mm(s_mm) * (s_mm * s_mm + d * d) / d
    }

    /// What a millimetre of s is worth in arcseconds of true angle, the mean over the stroke.
    pub fn arcsec_per_mm(&self) -> f64 {
        let slope = |theta| self.probes.error.slope_rad_per_mm(self.s_mm(theta));
        let count = stroke_points().count() as f64;
        arcsec_from_rad(stroke_points().map(slope).sum::<f64>() / count)
    }

    /// x₁ and x₂ in millimetres where the pair reports the difference s in pure rotation, and their
    /// derivatives with respect to s.
    pub fn reports_at(&self, s_mm: f64) -> ([f64; 2], [f64; 2]) {
        let reports = |s| self.report_mm(self.probes.error.true_angle_rad(s), 0.0);
        // The characteristics are smooth over tens of micrometres.
        let step = 1e-4;
        let (above, below) = (reports(s_mm + step), reports(s_mm - step));
        (reports(s_mm), std::array::from_fn(|i| (above[i] - below[i]) / (2.0 * step)))
    }

    /// s in millimetres for a calculated angle in radians.
    fn s_mm(&self, calculated_rad: f64) -> f64 {
        self.geometry.probe_distance_mm * calculated_rad.tan()
    }
}

/// Calculated angles in radians, evenly over the stroke.
fn stroke_points() -> impl Iterator<Item = f64> {
    (-34..=34).map(|i| f64::from(i) / 34.0 * STROKE_DEG.to_radians())
}
