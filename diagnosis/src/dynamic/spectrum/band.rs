//! Power spectra by Welch's method.

use numerics::fourier::{coefficients, hann};

/// Adds the power |X_k|² of the lines of segments of a record, which overlap by half, under Hann's window; the number of
/// segments.
pub fn add_segments(sums: &mut [f64], record: &[f64], length: usize) -> usize {
    let window = hann(length);
    let starts = (0..(record.len() + 1).saturating_sub(length)).step_by((length / 2).max(1));
    let each = starts.map(|start| {
        let part: Vec<f64> = record[start..].iter().zip(&window).map(|(v, w)| v * w).collect();
        sums.iter_mut().zip(coefficients(&part)).for_each(|(sum, x)| *sum += x.norm_sqr());
    });
    each.count()
}

/// One-sided power on the lines of a segment of `length` samples, mean over segments that overlap by half;
/// the sum over lines is the mean square.
pub fn power_spectrum(record: &[f64], length: usize) -> Vec<f64> {
    let length = length.clamp(1, record.len().max(1));
    let mut power = vec![0.0; length / 2 + 1];
    let count = add_segments(&mut power, record, length).max(1) as f64;
    for (k, power) in power.iter_mut().enumerate() {
        let sides = if k == 0 || 2 * k == length { 1.0 } else { 2.0 };
        *power = sides * *power / count;
    }
    power
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
