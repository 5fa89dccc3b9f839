//! Power of a residual by frequency band.

use super::fourier::{coefficients, hann};

/// A band and what lies in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// From this frequency, Hz.
    pub from_hz: f64,
    /// Up to this frequency, Hz.
    pub to_hz: f64,
    /// Power, unit of the record squared.
    pub power: f64,
}

/// Power of `record` in `count` bands of equal ratio from 1/200 of half the sampling rate up to it; what is
/// slower is in the first. Welch's segments with Hann's window.
pub fn bands(record: &[f64], step_s: f64, count: usize) -> Vec<Band> {
    let length = super::experiments::segment_length(record.len());
    let spectrum = power_spectrum(record, length);
    let half = 0.5 / step_s;
    let ratio = 200f64.powf(1.0 / count.max(1) as f64);
    let mut out: Vec<Band> = (0..count)
        .map(|k| Band {
            from_hz: if k == 0 { 0.0 } else { half / 200.0 * ratio.powi(k as i32) },
            to_hz: half / 200.0 * ratio.powi(k as i32 + 1),
            power: 0.0,
        })
        .collect();
    for (k, power) in spectrum.iter().enumerate() {
        let f = k as f64 / (length as f64 * step_s);
        let at = out.iter().position(|b| f < b.to_hz).unwrap_or(count.saturating_sub(1));
        if let Some(band) = out.get_mut(at) {
            band.power += power;
        }
    }
    out
}

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
    fn the_power_of_a_tone_lies_in_its_band_and_sums_to_its_mean_square() {
        let tone: Vec<f64> =
            (0..8000).map(|n| 2.0 * (std::f64::consts::TAU * 50.0 * n as f64 * 1e-3).sin()).collect();
        let found = bands(&tone, 1e-3, 20);
        let all: f64 = found.iter().map(|b| b.power).sum();
        assert!((all - 2.0).abs() < 0.02, "{all}");
        let own: f64 = found.iter().filter(|b| b.from_hz < 52.0 && b.to_hz > 48.0).map(|b| b.power).sum();
        assert!(own > 0.99 * all);
    }
}
