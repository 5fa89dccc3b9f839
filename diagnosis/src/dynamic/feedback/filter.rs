//! Zero-phase low-pass filtering: Butterworth of fourth order, once forward and once backward, and central
//! differences of what has passed it.

use crate::thresholds::dynamic::feedback::filter::QUALITIES;
use std::f64::consts::PI;

/// One second-order section (bilinear transformation), transposed direct form II.
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Section {
    fn new(cutoff_hz: f64, rate_hz: f64, quality: f64) -> Section {
        let k = (PI * cutoff_hz / rate_hz).tan();
        let norm = 1.0 / (1.0 + k / quality + k * k);
        let b0 = k * k * norm;
        Section { b: [b0, 2.0 * b0, b0], a: [2.0 * (k * k - 1.0) * norm, (1.0 - k / quality + k * k) * norm] }
    }

    /// Filters in place, started at rest at the first value.
    fn run(&self, x: &mut [f64]) {
        let Some(first) = x.first().copied() else { return };
        let mut s2 = (self.b[2] - self.a[1]) * first;
        let mut s1 = (self.b[1] - self.a[0]) * first + s2;
        for value in x {
            let input = *value;
            let output = self.b[0] * input + s1;
            s1 = self.b[1] * input - self.a[0] * output + s2;
            s2 = self.b[2] * input - self.a[1] * output;
            *value = output;
        }
    }
}

/// `x` through the filter forward and backward; at the ends it is continued by point reflection.
pub fn low_pass(x: &[f64], cutoff_hz: f64, step_s: f64) -> Vec<f64> {
    let rate_hz = 1.0 / step_s;
    if cutoff_hz >= 0.45 * rate_hz || x.len() < 4 {
        return x.to_vec();
    }
    let pad = ((10.0 * rate_hz / cutoff_hz) as usize).clamp(1, x.len() - 1);
    let last = x.len() - 1;
    let before = (1..=pad).rev().map(|k| 2.0 * x[0] - x[k]);
    let after = (1..=pad).map(|k| 2.0 * x[last] - x[last - k]);
    let mut y: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
    for _ in 0..2 {
        for quality in QUALITIES {
            Section::new(cutoff_hz, rate_hz, quality).run(&mut y);
        }
        y.reverse();
    }
    y[pad..pad + x.len()].to_vec()
}

/// Central differences of fourth order: at an eighth of the sampling rate, the highest cut-off that is tried, they are 1.2 %
/// low, those of second order 10 %. Of second order next to the ends, one-sided at them.
pub fn derivative(x: &[f64], step_s: f64) -> Vec<f64> {
    let last = x.len() - 1;
    let over = |k: usize, by: usize| (x[k + by] - x[k - by]) / (2.0 * by as f64 * step_s);
    let one = |k: usize| match k.min(last - k) {
        0 => {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
            (x[after] - x[before]) / ((after - before) as f64 * step_s)
        }
        1 => over(k, 1),
        _ => (4.0 * over(k, 1) - over(k, 2)) / 3.0,
    };
    (0..x.len()).map(one).collect()
}

/// The same of the second derivative; at the ends it is that of their neighbours.
pub fn second_derivative(x: &[f64], step_s: f64) -> Vec<f64> {
    let last = x.len() - 1;
    let over = |k: usize, by: usize| (x[k + by] - 2.0 * x[k] + x[k - by]) / (by as f64 * step_s).powi(2);
    let one = |k: usize| match k.min(last - k) {
        0 | 1 => over(k.clamp(1, last - 1), 1),
        _ => (4.0 * over(k, 1) - over(k, 2)) / 3.0,
    };
    (0..x.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_what_passes_are_nearly_right() {
        let rate = 2.0 * PI * 0.125;
        let x: Vec<f64> = (0..100).map(|k| (rate * f64::from(k)).sin()).collect();
        let (first, second) = (derivative(&x, 1.0), second_derivative(&x, 1.0));
        for k in 2..98 {
            let (sine, cosine) = (rate * k as f64).sin_cos();
            assert!((first[k] - rate * cosine).abs() < 0.013 * rate, "{k}: {}", first[k]);
            assert!((second[k] + rate * rate * sine).abs() < 0.005 * rate * rate, "{k}: {}", second[k]);
        }
        let square: Vec<f64> = (0..9).map(|k| f64::from(k * k)).collect();
        assert!(second_derivative(&square, 1.0).iter().all(|value| (value - 2.0).abs() < 1e-12));
    }

    #[test]
    fn passes_below_halves_at_the_cutoff_and_shifts_nothing() {
        let wave =
            |f: f64| -> Vec<f64> { (0..4000).map(|k| (2.0 * PI * f * k as f64 * 1e-3).sin()).collect() };
        for (f, gain) in [(2.0, 1.0), (40.0, 0.5), (160.0, 0.0)] {
            let (x, y) = (wave(f), low_pass(&wave(f), 40.0, 1e-3));
            let product: f64 = x[1000..3000].iter().zip(&y[1000..3000]).map(|(a, b)| a * b).sum();
            assert!((product / 1000.0 - gain).abs() < 5e-3, "{f} Hz: {}", product / 1000.0);
        }
        let line: Vec<f64> = (0..500).map(|k| 3.0 + 0.1 * k as f64).collect();
        assert!(low_pass(&line, 40.0, 1e-3).iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
