//! Weights from the scatter between passes.
//!
//! The scatter of six readings tells the noise of one angle only roughly (to ±30 %), and weights made of it
//! directly would cost more than they bring. So the variances are drawn together towards a common one, as
//! far as their own spread says that they differ at all (empirical Bayes: Smyth 2004, "Linear models and
//! empirical Bayes methods", Eq. for ν₀ and s₀²): on a recording of even noise all weights are 1. Where they
//! do differ, neighbouring angles are pooled first: what makes noise uneven (the gap, the drive, the edge
//! of the autocollimator's field) changes slowly with the angle.

use crate::statistics::readable;

pub use crate::coefficients::Scatter;

/// Variance of the values of a point, in their unit squared, with its degrees of freedom.
#[derive(Debug, Clone, Copy)]
pub struct Variance {
    /// Zero without degrees of freedom.
    pub value: f64,
    /// Readings less means.
    pub freedom: usize,
}

impl Variance {
    /// That of several together; 0 where no freedom is left.
    pub fn pooled(variances: &[Variance]) -> Variance {
        let freedom = variances.iter().map(|v| v.freedom).sum();
        let squares: f64 = variances.iter().map(|v| v.value * v.freedom as f64).sum();
        Variance { value: if freedom > 0 { squares / freedom as f64 } else { 0.0 }, freedom }
    }

    /// The scatter between passes that it says; none where no angle repeats.
    pub fn scatter(&self, weighted: bool) -> Option<Scatter> {
        let (standard_deviation, degrees_of_freedom) = (readable(self.value.sqrt()), self.freedom);
        (self.freedom > 0).then_some(Scatter { standard_deviation, degrees_of_freedom, weighted })
    }
}

/// One weight per point, with a mean of about 1, and whether they differ.
pub(crate) fn weights(variances: &[Variance]) -> (Vec<f64>, bool) {
    let even = (vec![1.0; variances.len()], false);
    let known: Vec<&Variance> = variances.iter().filter(|v| v.freedom > 0 && v.value > 0.0).collect();
    if known.len() < 6 || 2 * known.len() < variances.len() {
        return even;
    }
    // ln s² scatters about ln σ² + digamma(ν/2) − ln(ν/2), with a variance of trigamma(ν/2).
    let logs: Vec<f64> = known.iter().map(|v| v.value.ln() - bias(v.freedom as f64)).collect();
    let count = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / count;
    let spread = logs.iter().map(|log| (log - mean) * (log - mean)).sum::<f64>() / (count - 1.0);
    let expected = known.iter().map(|v| trigamma(0.5 * v.freedom as f64)).sum::<f64>() / count;
    // Under even noise the spread has a relative standard error of about √(3/count) (ln χ² has heavy
    // tails); below two of them nothing is weighted.
    if spread - expected < 2.0 * expected * (3.0 / count).sqrt() {
        return even;
    }
    let prior = 2.0 * inverse_trigamma(spread - expected);
    let common = (mean + bias(prior)).exp();
    let shrunk: Vec<f64> = (0..variances.len())
        .map(|point| {
            let Variance { value, freedom } = pooled(variances, point);
            (prior * common + freedom as f64 * value) / (prior + freedom as f64)
        })
        .collect();
    let scale = shrunk.len() as f64 / shrunk.iter().map(|v| 1.0 / v).sum::<f64>();
    // Nine digits, so that the last bit of a logarithm cannot reach the coefficients.
    (shrunk.iter().map(|v| readable(scale / v)).collect(), true)
}

/// The variance of the points around one, a tenth of them on either side.
fn pooled(variances: &[Variance], point: usize) -> Variance {
    let reach = (variances.len() / 10).max(1);
    let around = &variances[point.saturating_sub(reach)..(point + reach + 1).min(variances.len())];
    Variance::pooled(around)
}

/// digamma(ν/2) − ln(ν/2).
fn bias(freedom: f64) -> f64 {
    statrs::function::gamma::digamma(0.5 * freedom) - (0.5 * freedom).ln()
}

/// ψ′(x): recurrence up to x ≥ 8, then the asymptotic series (Abramowitz & Stegun 6.4.12).
fn trigamma(mut x: f64) -> f64 {
    let mut sum = 0.0;
    while x < 8.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    sum + 1.0 / x + 0.5 * y + y / x * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y / 30.0)))
}

/// The x at which ψ′(x) = `value`; ψ′ falls monotonically, so bisection cannot fail.
fn inverse_trigamma(value: f64) -> f64 {
    let (mut low, mut high) = (1e-6f64, 1e9f64);
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if trigamma(middle) > value { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trigamma_at_known_points() {
        let pi = std::f64::consts::PI;
        approx::assert_relative_eq!(trigamma(1.0), pi * pi / 6.0, epsilon = 1e-10);
        approx::assert_relative_eq!(trigamma(0.5), pi * pi / 2.0, epsilon = 1e-10);
        approx::assert_relative_eq!(trigamma(inverse_trigamma(0.3)), 0.3, epsilon = 1e-9);
    }

    #[test]
    fn clearly_uneven_noise_is_weighted_and_even_noise_is_not() {
        // Variances as they scatter for five degrees of freedom: quantiles of χ²₅/5.
        let quantiles = [0.23, 0.42, 0.58, 0.73, 0.87, 1.03, 1.21, 1.44, 1.75, 2.3];
        let at = |factor: f64| quantiles.iter().map(move |q| Variance { value: factor * q, freedom: 5 });
        let even: Vec<Variance> = at(1.0).chain(at(1.0)).collect();
        assert_eq!(weights(&even), (vec![1.0; 20], false));
        let uneven: Vec<Variance> = at(1.0).chain(at(100.0)).collect();
        let (weights, weighted) = weights(&uneven);
        assert!(weighted);
        let mean = |w: &[f64]| w.iter().sum::<f64>() / w.len() as f64;
        assert!(mean(&weights[..10]) > 10.0 * mean(&weights[10..]));
    }
}
