//! What nobody in the laboratory knows about a recording.

use crate::effects::Pose;
use crate::noise::Noise;

/// What was true beside one reading; never written to a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// True angle of the mirror in radians.
    pub true_angle_rad: f64,
    /// The zero α₀ of the autocollimator in arcseconds, the same in every row.
    pub zero_arcsec: f64,
    /// Δθ_M in arcseconds with the true zero, before the log rounds it.
    pub error_arcsec: f64,
    /// What of the reading of the reference is noise, in arcseconds.
    pub reference_noise_arcsec: f64,
    /// Standard deviation in arcseconds of what the probes' repeatability does to this reading's Δθ_M.
    pub probe_noise_arcsec: f64,
    /// Standard deviation in arcseconds of the autocollimator's noise in this reading, outliers included
    /// with their share.
    pub optics_noise_arcsec: f64,
    /// Whether this reading is an outlier.
    pub outlier: bool,
    /// Where everything stood.
    pub pose: Pose,
}

impl Truth {
    /// Standard deviation of the noise of this reading in arcseconds.
    pub fn noise_arcsec(&self) -> f64 {
        self.probe_noise_arcsec.hypot(self.optics_noise_arcsec)
    }
}

/// Σ, the true covariance of the noise of Δθ_M, in square arcseconds, row by row of a square matrix with a
/// row for every reading.
pub fn noise_covariance(truths: &[Truth], noise: &Noise) -> Vec<f64> {
    let mut covariance = Vec::with_capacity(truths.len() * truths.len());
    for a in truths {
        covariance.extend(truths.iter().map(|b| {
            let together =
                a.probe_noise_arcsec * b.probe_noise_arcsec + a.optics_noise_arcsec * b.optics_noise_arcsec;
            together * noise.correlation(a.pose.t_s - b.pose.t_s)
        }));
    }
    covariance
}
