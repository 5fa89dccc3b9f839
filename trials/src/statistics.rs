//! Exact limits for proportions, and what an ideal detector achieves.

use rand::RngExt;
use statrs::distribution::{ContinuousCDF, Normal};
use statrs::function::beta::beta_reg;

/// The largest share for which at most `hits` of `of` still have the probability `1 − confidence`
/// (Clopper, Pearson 1934, one-sided).
pub fn upper_limit(hits: u64, of: u64, confidence: f64) -> f64 {
    if hits >= of {
        return 1.0;
    }
    // P(at most k hits | p) = I(1−p; n−k, k+1), which falls with p.
    let (n, k) = (of as f64, hits as f64);
    bisect(|p| beta_reg(n - k, k + 1.0, 1.0 - p) > 1.0 - confidence)
}

/// The least share for which at least `hits` of `of` still have the probability `1 − confidence`.
pub fn lower_limit(hits: u64, of: u64, confidence: f64) -> f64 {
    1.0 - upper_limit(of - hits.min(of), of, confidence)
}

/// Two-sided p-value of `hits` of `of` where each has the probability `p`: twice the smaller tail.
pub fn binomial_p_value(hits: u64, of: u64, p: f64) -> f64 {
    let (n, k) = (of as f64, hits as f64);
    let at_most = if hits >= of { 1.0 } else { beta_reg(n - k, k + 1.0, 1.0 - p) };
    let at_least = if hits == 0 { 1.0 } else { beta_reg(k, n - k + 1.0, p) };
    (2.0 * at_most.min(at_least)).min(1.0)
}

/// The largest value in [0, 1] up to which `below` holds.
fn bisect(below: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Φ, the distribution of a standard normal deviate.
pub fn phi(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// The inverse of Φ.
pub fn quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// A standard normal deviate (Box, Muller 1958).
pub fn standard_normal(generator: &mut impl RngExt) -> f64 {
    let radius = (-2.0 * generator.random::<f64>().max(1e-300).ln()).sqrt();
    radius * (std::f64::consts::TAU * generator.random::<f64>()).cos()
}

/// Probability that a matched filter, told the effect's shape and the noise, but not the sign, detects an
/// effect of strength ρ at the given false-alarm rate.
pub fn ideal_detection(rho: f64, false_alarm: f64) -> f64 {
    let threshold = quantile(1.0 - 0.5 * false_alarm);
    phi(rho - threshold) + phi(-rho - threshold)
}

/// The value below which the share `part` of the values lies (of the sorted values, interpolated linearly).
pub fn percentile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let place = part * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (place - below as f64) * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_clopper_and_pearson() {
        // No hit: (1 − p)^n = 5 %.
        assert!((upper_limit(0, 2000, 0.95) - (1.0 - 0.05f64.powf(1.0 / 2000.0))).abs() < 1e-9);
        // Published for 5 of 10, 95 % two-sided: 0.1871 … 0.8129.
        assert!((upper_limit(5, 10, 0.975) - 0.8129).abs() < 1e-4);
        assert!((lower_limit(5, 10, 0.975) - 0.1871).abs() < 1e-4);
        assert_eq!(upper_limit(7, 7, 0.95), 1.0);
    }

    #[test]
    fn binomial_tails() {
        // P(X ≤ 1 | 4, 1/2) = 5/16.
        assert!((binomial_p_value(1, 4, 0.5) - 0.625).abs() < 1e-12);
        assert!((binomial_p_value(0, 4, 0.5) - 0.125).abs() < 1e-12);
        assert_eq!(binomial_p_value(2, 4, 0.5), 1.0);
    }

    #[test]
    fn an_ideal_detector_starts_at_the_false_alarms() {
        assert!((ideal_detection(0.0, 0.01) - 0.01).abs() < 1e-9);
        assert!(ideal_detection(6.0, 0.01) > 0.999);
    }

    #[test]
    fn percentiles_interpolate() {
        assert_eq!(percentile(&[3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(percentile(&[0.0, 1.0], 0.95), Some(0.95));
        assert_eq!(percentile(&[], 0.5), None);
    }
}
