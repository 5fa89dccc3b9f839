//! Quantiles of a mixture of normal distributions, such as a parameter's posterior is made of.

use statrs::function::erf::erf;

/// One normal part of a mixture.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// Its share.
    pub weight: f64,
    /// Its mean.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// The value below which `part` of a normal mixture lies. A part without any deviation is a place on a grid,
/// and counts as spread over the distance to its neighbours.
pub fn quantile(mixture: &[Part], part: f64) -> f64 {
    if mixture.iter().all(|p| p.deviation == 0.0) {
        return quantile_of_places(mixture, part);
    }
    let low = mixture.iter().map(|p| p.value - 6.0 * p.deviation).fold(f64::INFINITY, f64::min);
    let high = mixture.iter().map(|p| p.value + 6.0 * p.deviation).fold(f64::NEG_INFINITY, f64::max);
    let below = |v: f64| -> f64 {
        mixture
            .iter()
            .map(|p| {
                let z = (v - p.value) / p.deviation.max(1e-300);
                p.weight * 0.5 * (1.0 + erf((z * std::f64::consts::FRAC_1_SQRT_2).clamp(-40.0, 40.0)))
            })
            .sum()
    };
    let (mut low, mut high) = (low, high);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if below(middle) < part { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The same for values on a grid: each place's weight lies evenly between the middles to its neighbours.
fn quantile_of_places(mixture: &[Part], part: f64) -> f64 {
    let mut sorted: Vec<(f64, f64)> = mixture.iter().map(|p| (p.value, p.weight)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Places of one value (the other axis of a square) are one.
    let mut merged: Vec<(f64, f64)> = Vec::with_capacity(sorted.len());
    for (value, weight) in sorted {
        match merged.last_mut() {
            Some(last) if value - last.0 <= 1e-9 * value.abs() => last.1 += weight,
            _ => merged.push((value, weight)),
        }
    }
    let mut left = part;
    for (i, (value, weight)) in merged.iter().enumerate() {
        if left <= *weight {
            let before = if i > 0 { 0.5 * (merged[i - 1].0 + value) } else { *value };
            let after = merged.get(i + 1).map_or(*value, |next| 0.5 * (next.0 + value));
            return before + (after - before) * left / weight;
        }
        left -= weight;
    }
    merged.last().map_or(f64::NAN, |p| p.0)
}

#[cfg(test)]
mod tests {
    use super::{Part, quantile};

    #[test]
    fn one_normal_part_has_the_normal_interval() {
        let one = [Part { weight: 1.0, value: 3.0, deviation: 0.5 }];
        assert!((quantile(&one, 0.975) - (3.0 + 0.5 * 1.959_964)).abs() < 1e-6);
        assert!((quantile(&one, 0.025) - (3.0 - 0.5 * 1.959_964)).abs() < 1e-6);
    }

    #[test]
    fn two_far_parts_are_both_in_the_interval() {
        let part = |value| Part { weight: 0.5, value, deviation: 0.1 };
        let two = [part(0.0), part(10.0)];
        assert!(quantile(&two, 0.025) < 0.0 && quantile(&two, 0.975) > 10.0);
    }

    #[test]
    fn places_on_an_even_grid_give_an_even_distribution() {
        let even: Vec<Part> =
            (0..101).map(|i| Part { weight: 1.0 / 101.0, value: f64::from(i), deviation: 0.0 }).collect();
        // 2.5 % of an even distribution from 0 to 100.
        assert!((quantile(&even, 0.025) - 2.5).abs() < 0.6);
    }
}
