//! `periodic`: harmonics of the *true* angle Θ, two coefficients each: of cos(2πkΘ/p) and of sin(2πkΘ/p).
//!
//! The error of a resolver, an encoder or a screw repeats with where the axis really is, not with what the
//! sensor says. So the corrected angle solves Θ + Σ Pⱼ(Θ) = θ − (all other errors), by Newton's method;
//! the solution is the only one as long as the error's slope stays below 1.

use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Periodic {
    /// p, the period of the first harmonic, in the unit of the result (arcsec, or the direct sensor's).
    pub period: f64,
    /// The numbers k of the harmonics, in the order of the coefficients.
    pub harmonics: Vec<u16>,
}

impl Periodic {
    /// Harmonics 1 … `harmonics` of a period.
    pub fn of(period: f64, harmonics: u16) -> Periodic {
        Periodic { period, harmonics: (1..=harmonics).collect() }
    }

    /// The columns at a true angle: cos and sin of each harmonic.
    pub fn columns_at(&self, truth: f64) -> Vec<f64> {
        (self.harmonics.iter())
            .flat_map(|k| {
                let phase = TAU * f64::from(*k) * turns(truth / self.period);
                [libm::cos(phase), libm::sin(phase)]
            })
            .collect()
    }

    /// Value and slope of Σ coefficient·column at a true angle.
    pub fn value_and_slope(&self, coefficients: &[f64], truth: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for (k, pair) in self.harmonics.iter().zip(coefficients.chunks_exact(2)) {
            let rate = TAU * f64::from(*k) / self.period;
            let phase = TAU * f64::from(*k) * turns(truth / self.period);
            let (sine, cosine) = (libm::sin(phase), libm::cos(phase));
            value += pair[0] * cosine + pair[1] * sine;
            slope += rate * (pair[1] * cosine - pair[0] * sine);
        }
        (value, slope)
    }

    /// The steepest slope that the harmonics could have together.
    pub fn steepest(&self, coefficients: &[f64]) -> f64 {
        (self.harmonics.iter().zip(coefficients.chunks_exact(2)))
            .map(|(k, pair)| TAU * f64::from(*k) / self.period * (pair[0].hypot(pair[1])))
            .sum()
    }

    pub(super) fn contradiction(&self, coefficients: &[f64]) -> Option<String> {
        if !(self.period.is_finite() && self.period > 0.0) {
            return Some(format!("`period` of a `periodic` term is {}", self.period));
        }
        if self.harmonics.contains(&0) {
            return Some("a `periodic` term has a harmonic number 0".to_string());
        }
        let steepest = self.steepest(coefficients);
        (steepest >= 1.0).then(|| {
            format!("a `periodic` term has a slope of up to {steepest:.2}, and from 1 on it has no inverse")
        })
    }
}

/// The part of a number of turns after the point: exact, so that large angles keep their phase.
fn turns(count: f64) -> f64 {
    count - count.floor()
}

/// Solves Θ + Σ P(Θ) = observed for all periodic terms together. Newton's method, kept between the bounds
/// that the terms' amplitudes give; each step halves the bracket at least where Newton would leave it.
pub(crate) fn solve(terms: &[(&Periodic, &[f64])], observed: f64) -> f64 {
    let reach: f64 = (terms.iter())
        .map(|(_, coefficients)| coefficients.chunks_exact(2).map(|p| p[0].hypot(p[1])).sum::<f64>())
        .sum();
    let (mut low, mut high) = (observed - reach, observed + reach);
    let mut truth = observed;
    for _ in 0..100 {
        let (mut rest, mut slope) = (truth - observed, 1.0);
        for (periodic, coefficients) in terms {
            let (value, rate) = periodic.value_and_slope(coefficients, truth);
            rest += value;
            slope += rate;
        }
        if rest > 0.0 {
            high = truth
        } else {
            low = truth
        }
        let newton = truth - rest / slope;
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        // Below the spacing of numbers there is nothing left to gain.
        if (next - truth).abs() <= 4.0 * f64::EPSILON * observed.abs().max(reach) {
            return next;
        }
        truth = next;
    }
    truth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_true_angle_is_found_back() {
        let periodic = Periodic::of(0.25, 2);
        let coefficients = [0.015, 0.012, 0.001, -0.002];
        assert!(periodic.steepest(&coefficients) < 1.0);
        for i in 0..1000 {
            let truth = -22.0 + 0.001 * f64::from(i);
            let observed = truth + periodic.value_and_slope(&coefficients, truth).0;
            let found = solve(&[(&periodic, &coefficients)], observed);
            approx::assert_abs_diff_eq!(found, truth, epsilon = 1e-13);
        }
    }
}
