//! Nonlinear distortion of a periodic recording: where a multisine leaves lines free, even ones collect even
//! distortion and odd ones odd distortion at once.
//!
//! Source: Pintelon & Schoukens, sections 4.3 and 4.4; T. D'haene et al., IEEE Trans. Instrum. Meas. 54 (2005).

use std::ops::Range;

use fitter::table::Values;

use super::experiments::period_spectra;
use crate::thresholds::dynamic::spectrum::distortion::FREE;

/// Frequencies in Hz with the mean power there.
pub type Lines = Vec<(f64, f64)>;

/// Adds the free lines of the excited band, run by run: `(even, odd)`, each frequency and mean power over
/// the runs that leave the line free.
pub fn free_lines(
    drives: &[Values],
    positions: &[Values],
    runs: &[Range<usize>],
    length: usize,
    step_s: f64,
) -> (Lines, Lines) {
    let last = length.saturating_sub(1) / 2;
    let mut sums = vec![(0.0, 0usize); last + 1];
    for run in runs {
        let [u, y] = [drives, positions].map(|channels| period_spectra(channels, run, length));
        let power: Vec<f64> = (0..=last).map(|k| u.iter().map(|u| u[k].norm_sqr()).sum()).collect();
        let strongest = power.iter().skip(1).copied().fold(0.0, f64::max);
        let excited: Vec<usize> = (1..=last).filter(|&k| power[k] > FREE * strongest).collect();
        let (Some(&first), Some(&end)) = (excited.first(), excited.last()) else { continue };
        for k in first..=end {
            if power[k] <= FREE * strongest {
                sums[k].0 += y.iter().map(|y| y[k].norm_sqr()).sum::<f64>();
                sums[k].1 += 1;
            }
        }
    }
    let unit = 1.0 / (length as f64 * step_s);
    let lines = |parity: usize| {
        let free = sums.iter().enumerate().filter(|(k, (_, n))| k % 2 == parity && *n > 0);
        free.map(|(k, (sum, n))| (k as f64 * unit, sum / *n as f64)).collect()
    };
    (lines(0), lines(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Odd multisines through x + 0.1 x² or x + 0.1 x³, two periods each.
    fn recording(power: i32) -> (Vec<f64>, Vec<f64>, Vec<Range<usize>>) {
        let (mut u, mut y, mut runs) = (vec![], vec![], vec![]);
        for run in 0..4u32 {
            let phase = |k: u32| ((k * 7919 + run * 104_729) % 6283) as f64 / 1000.0;
            let start = u.len();
            for n in 0..512 {
                let t = std::f64::consts::TAU * (n % 256) as f64 / 256.0;
                let x: f64 = (1..40).step_by(2).map(|k| (k as f64 * t + phase(k)).cos() / 4.0).sum();
                u.push(x);
                y.push(x + 0.1 * x.powi(power));
            }
            runs.push(start..u.len());
        }
        (u, y, runs)
    }

    #[test]
    fn even_and_odd_distortion_stand_on_their_lines() {
        for (power, even_expected) in [(2, true), (3, false)] {
            let (u, y, runs) = recording(power);
            let (even, odd) = free_lines(&[u.into()], &[y.into()], &runs, 256, 1e-3);
            let sum = |lines: &[(f64, f64)]| lines.iter().map(|l| l.1).sum::<f64>();
            assert!(!even.is_empty());
            assert_eq!(sum(&even) > 1e-6, even_expected);
            assert!(odd.iter().all(|l| l.1 < 1e-20));
        }
    }
}
