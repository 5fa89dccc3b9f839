//! Power spectra by Welch's method.

use super::fourier::{coefficients, hann};

/// One-sided power on the lines of a segment of `length` samples, mean over segments that overlap by half;
/// the sum over lines is the mean square.
pub fn power_spectrum(record: &[f64], length: usize) -> Vec<f64> {
    let length = length.clamp(1, record.len().max(1));
    let window = hann(length);
    let mut sum = vec![0.0; length / 2 + 1];
    let mut count = 0.0;
    let mut start = 0;
    while start + length <= record.len() {
        let part: Vec<f64> = record[start..start + length].iter().zip(&window).map(|(v, w)| v * w).collect();
        for (k, (s, x)) in sum.iter_mut().zip(coefficients(&part)).enumerate() {
            let sides = if k == 0 || 2 * k == length { 1.0 } else { 2.0 };
            *s += sides * x.norm_sqr();
        }
        count += 1.0;
        start += (length / 2).max(1);
    }
    sum.iter_mut().for_each(|s| *s /= f64::max(count, 1.0));
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_of_a_tone_stands_on_its_line_and_sums_to_its_mean_square() {
        let tone: Vec<f64> =
            (0..8000).map(|n| 2.0 * (std::f64::consts::TAU * 50.0 * n as f64 * 1e-3).sin()).collect();
        let power = power_spectrum(&tone, 1000);
        let all: f64 = power.iter().sum();
        assert!((all - 2.0).abs() < 0.02, "{all}");
        assert!(power[48..=52].iter().sum::<f64>() > 0.99 * all);
    }
}
