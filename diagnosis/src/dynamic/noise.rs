//! The noise of a residual as an autoregression: what is predictable of a residual from its own past is
//! taken out before anything is tested, so that coloured noise raises no alarm.

use crate::thresholds::dynamic::noise::MOST;
use std::ops::Range;

/// An autoregression e_t = x_t − Σ c_j x_(t−j).
#[derive(Debug, Clone)]
pub struct Autoregression {
    /// The coefficients c.
    pub coefficients: Vec<f64>,
    /// Standard deviation of e.
    pub innovation: f64,
}

/// The autoregression of a residual, its order chosen by the criterion of Schwarz (1978).
pub fn autoregression(residual: &[f64], runs: &[Range<usize>]) -> Autoregression {
    let rows: usize = runs.iter().map(|r| r.len()).sum();
    let lagged = |lag: usize| -> f64 {
        let of = |run: &Range<usize>| {
            let x = &residual[run.clone()];
            x.iter().zip(&x[lag.min(x.len())..]).map(|(a, b)| a * b).sum::<f64>()
        };
        runs.iter().map(of).sum::<f64>() / rows.max(1) as f64
    };
    let covariance: Vec<f64> = (0..=MOST).map(lagged).collect();
    // Levinson's and Durbin's recursion.
    let mut variance = covariance[0];
    let mut coefficients: Vec<f64> = Vec::new();
    let mut best = (f64::INFINITY, Vec::new(), variance);
    for order in 0..=MOST {
        let n = rows as f64;
        let criterion = n * variance.max(f64::MIN_POSITIVE).ln() + order as f64 * n.ln();
        if criterion < best.0 {
            best = (criterion, coefficients.clone(), variance);
        }
        if order == MOST || variance.is_nan() || variance <= 1e-12 * covariance[0] {
            break;
        }
        let predicted: f64 = coefficients.iter().enumerate().map(|(j, c)| c * covariance[order - j]).sum();
        let reflection = (covariance[order + 1] - predicted) / variance;
        let mirrored: Vec<f64> = coefficients.iter().rev().map(|c| reflection * c).collect();
        for (c, m) in coefficients.iter_mut().zip(&mirrored) {
            *c -= m;
        }
        coefficients.push(reflection);
        variance *= 1.0 - reflection * reflection;
    }
    Autoregression { coefficients: best.1, innovation: best.2.max(0.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_order_noise_is_recognised() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut x = vec![0.0];
        for k in 1..20_000 {
            x.push(0.8 * x[k - 1] + random());
        }
        let whole = 0..x.len();
        let found = autoregression(&x, std::slice::from_ref(&whole));
        assert_eq!(found.coefficients.len(), 1);
        assert!((found.coefficients[0] - 0.8).abs() < 0.02);
        assert!((found.innovation - (1.0f64 / 12.0).sqrt()).abs() < 0.01);
    }
}
