//! The reference: an electronic autocollimator with an unknown zero, its own noise and a second axis.

/// An autocollimator on its table, in front of the mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Autocollimator {
    /// Standard deviation of its own reading in arcseconds.
    pub noise_arcsec: f64,
    /// Standard deviation of what air and table add to one reading, in arcseconds.
    pub pointing_arcsec: f64,
    /// Standard deviation of the reading of the second axis in arcseconds.
    pub cross_noise_arcsec: f64,
    /// Half its measuring range, in arcseconds.
    pub range_arcsec: f64,
    /// α₀ is drawn uniformly up to this size in either direction, in arcseconds: the knobs bring the
    /// beam near the centre.
    pub zero_within_arcsec: f64,
}

impl Default for Autocollimator {
    /// The paper's: ±1.5°, and an accuracy of 1″ taken as three standard deviations. Air and table are
    /// what is left to 0.5″ in all, beside the probes' 0.34″.
    fn default() -> Self {
        Self {
            noise_arcsec: 1.0 / 3.0,
            pointing_arcsec: 0.15,
            // The second axis stays at the centre of its range, where a reading is at its best.
            cross_noise_arcsec: 0.05,
            range_arcsec: 5400.0,
            zero_within_arcsec: 100.0,
        }
    }
}

impl Autocollimator {
    /// Standard deviation of one reading in arcseconds, from both causes.
    pub fn total_noise_arcsec(&self) -> f64 {
        self.noise_arcsec.hypot(self.pointing_arcsec)
    }
}
