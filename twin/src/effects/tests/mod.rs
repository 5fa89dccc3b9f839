//! What an effect does to a recording, against what the table of effects says that it adds.

mod all;
mod table;

use crate::device::Device;
use crate::geometry::calculated_angle_rad;
use crate::protocol::Protocol;
use crate::record::{contributions, record_noiseless};
use crate::units::arcsec_from_rad;
use crate::{Injected, Reading, Truth};

fn calculated(x1: f64, x2: f64) -> f64 {
    calculated_angle_rad(x1, x2, 12.0)
}

/// A recording of a device with one effect: what was recorded without noise, and what the effect added.
struct Case {
    rows: Vec<(Reading, Truth)>,
    added: Vec<f64>,
}

impl Case {
    fn new(effect: &Injected, protocol: &Protocol, seed: u64) -> Self {
        let device = Device::from_seed(seed).with_effects(vec![effect.clone()]).unwrap();
        let rows = record_noiseless(&device, protocol, seed, &calculated);
        let added = contributions(&device, protocol, seed, &calculated).remove(0);
        Self { rows, added }
    }

    /// What a formula of the recorded row gives.
    fn formula(&self, of: impl Fn(&Reading) -> f64) -> Vec<f64> {
        self.rows.iter().map(|(reading, _)| of(reading)).collect()
    }

    /// What a polynomial of order `order` in s leaves of values row by row.
    fn beyond(&self, values: &[f64], order: usize) -> Vec<f64> {
        let s: Vec<f64> = self.rows.iter().map(|(r, _)| r.x2_mm - r.x1_mm).collect();
        crate::orthogonal::residual(&s, values, order)
    }

    /// What was added is `formula`, after a polynomial of order `order` in s is taken off both: the relative
    /// difference in the root mean square, and the factor between them by least squares.
    fn compare(&self, formula: &[f64], order: usize) -> (f64, f64) {
        let (added, wanted) = (self.beyond(&self.added, order), self.beyond(formula, order));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let difference: Vec<f64> = added.iter().zip(&wanted).map(|(a, w)| a - w).collect();
        let square = dot(&wanted, &wanted);
        assert!(square > 0.0, "the formula is zero");
        ((dot(&difference, &difference) / square).sqrt(), dot(&added, &wanted) / square)
    }
}

/// The calculated angle of a row in arcseconds.
fn theta_arcsec(r: &Reading) -> f64 {
    arcsec_from_rad(calculated(r.x1_mm, r.x2_mm))
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}
