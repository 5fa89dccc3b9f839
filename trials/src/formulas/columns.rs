//! The columns that the formulas are made of, in the units of the table.

use twin::Reading;
use twin::units::arcsec_from_rad;

use crate::linear::mean;

/// Order of the base model against which everything is measured: that of the devices' own error, Eq. 12.
pub const BASE_ORDER: usize = 9;

/// One recording by columns.
#[derive(Debug, Clone)]
pub struct Columns {
    pub s_mm: Vec<f64>,
    /// Calculated angle θ in arcseconds.
    pub theta_arcsec: Vec<f64>,
    /// Δθ_M = θ − reference in arcseconds, its mean removed.
    pub error_arcsec: Vec<f64>,
    /// The true angle in arcseconds but for a constant: θ less a polynomial of s that was fitted once.
    pub true_arcsec: Vec<f64>,
    pub t_s: Vec<f64>,
    /// Speed of the calculated angle in arcsec/s within its pass.
    pub velocity: Vec<f64>,
    pub temperature_c: Vec<f64>,
    /// (x₁+x₂)/2 in micrometres.
    pub common_um: Vec<f64>,
    /// Second axis in arcseconds.
    pub cross_arcsec: Vec<f64>,
    pub coil_a: Vec<f64>,
    /// The stroke that places and periods are counted in: least and largest of `true_arcsec` …
    pub true_arcsec_range: [f64; 2],
    /// … the largest |θ| in arcseconds, …
    pub theta_end_arcsec: f64,
    /// … and the mean temperature, in °C. Kept from one recording to the next by [`Columns::on_scale_of`].
    pub mean_c: f64,
}

impl Columns {
    /// The columns of a recording of probes `distance_mm` apart.
    pub fn new(log: &[Reading], distance_mm: f64) -> Self {
        let s_mm: Vec<f64> = log.iter().map(|r| r.x2_mm - r.x1_mm).collect();
        let theta_arcsec: Vec<f64> = log
            .iter()
            .map(|r| arcsec_from_rad(twin::calculated_angle_rad(r.x1_mm, r.x2_mm, distance_mm)))
            .collect();
        let raw: Vec<f64> = log.iter().zip(&theta_arcsec).map(|(r, t)| t - r.reference_arcsec).collect();
        let offset = mean(&raw);
        let mut columns = Self {
            error_arcsec: raw.iter().map(|e| e - offset).collect(),
            true_arcsec: Vec::new(),
            t_s: log.iter().map(|r| r.t_s).collect(),
            velocity: velocity(log, &theta_arcsec),
            temperature_c: log.iter().map(|r| r.temperature_c).collect(),
            common_um: log.iter().map(|r| 500.0 * (r.x1_mm + r.x2_mm)).collect(),
            cross_arcsec: log.iter().map(|r| r.cross_arcsec).collect(),
            coil_a: log.iter().map(|r| r.coil_a).collect(),
            true_arcsec_range: [0.0; 2],
            theta_end_arcsec: theta_arcsec.iter().fold(0.0, |most, t| t.abs().max(most)),
            mean_c: mean(&log.iter().map(|r| r.temperature_c).collect::<Vec<f64>>()),
            s_mm,
            theta_arcsec,
        };
        columns.true_arcsec = columns.turned(&log.iter().map(|r| r.reference_arcsec).collect::<Vec<_>>());
        let ends = |low: f64, high: f64, v: &f64| (low.min(*v), high.max(*v));
        let (low, high) =
            columns.true_arcsec.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| ends(l, h, v));
        columns.true_arcsec_range = [low, high];
        columns
    }

    /// With the scales of another recording of the device, so that nonlinear parameters mean the same.
    pub fn on_scale_of(mut self, other: &Self) -> Self {
        self.true_arcsec_range = other.true_arcsec_range;
        self.theta_end_arcsec = other.theta_end_arcsec;
        self.mean_c = other.mean_c;
        self
    }

    pub fn rows(&self) -> usize {
        self.t_s.len()
    }

    /// The columns of the base model: a constant, and Eq. 6 up to `BASE_ORDER`, in Chebyshev polynomials
    /// of s over `half_mm` for the sake of the arithmetic.
    pub fn base(&self, half_mm: f64, distance_mm: f64) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![1.0; self.rows()]];
        let factor = |s: f64| distance_mm * distance_mm / (s * s + distance_mm * distance_mm);
        for order in 0..=BASE_ORDER {
            let at = |s: &f64| factor(*s) * chebyshev(order, s / half_mm);
            columns.push(self.s_mm.iter().map(at).collect());
        }
        columns
    }

    /// Largest |s| in millimetres.
    pub fn half_mm(&self) -> f64 {
        self.s_mm.iter().fold(0.0, |most, s| s.abs().max(most))
    }

    /// Length of the recording in seconds.
    pub fn duration_s(&self) -> f64 {
        self.t_s.last().map_or(0.0, |last| last - self.t_s[0])
    }

    /// The reference smoothed by a polynomial of s, about its value at s = 0: the same function of s whatever
    /// the zero of the recording.
    fn turned(&self, reference_arcsec: &[f64]) -> Vec<f64> {
        let half = self.half_mm();
        let column =
            |order: usize| self.s_mm.iter().map(|s| chebyshev(order, s / half)).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = (0..=BASE_ORDER).map(column).collect();
        let amplitudes = crate::linear::least_squares(&columns, reference_arcsec);
        let at = |s: f64| -> f64 {
            amplitudes.iter().enumerate().map(|(order, a)| a * chebyshev(order, s / half)).sum()
        };
        self.s_mm.iter().map(|s| at(*s) - at(0.0)).collect()
    }
}

/// T_n(x) by the recurrence; beyond ±1 as the polynomial goes on.
fn chebyshev(order: usize, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, x);
    for _ in 0..order {
        (before, now) = (now, 2.0 * x * now - before);
    }
    before
}

/// dθ/dt from the neighbours in the same pass, in arcsec/s.
fn velocity(log: &[Reading], theta_arcsec: &[f64]) -> Vec<f64> {
    (0..log.len())
        .map(|i| {
            let same = |j: usize| log[j].pass == log[i].pass;
            let before = if i > 0 && same(i - 1) { i - 1 } else { i };
            let after = if i + 1 < log.len() && same(i + 1) { i + 1 } else { i };
            let step_s = log[after].t_s - log[before].t_s;
            if step_s > 0.0 { (theta_arcsec[after] - theta_arcsec[before]) / step_s } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chebyshev_polynomials() {
        let x: f64 = 0.3;
        for order in 0..10 {
            let wanted = (order as f64 * x.acos()).cos();
            assert!((chebyshev(order, x) - wanted).abs() < 1e-12);
        }
    }
}
