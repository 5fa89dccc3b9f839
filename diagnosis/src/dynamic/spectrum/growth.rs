//! Gain and resonances against the amplitude of the excitation: the signature of whatever is nonlinear and
//! keeps the frequency response in shape.

use super::{Complex, Response};
use crate::thresholds::dynamic::spectrum::growth::{REACH, RESONANCES};

/// One amplitude's gain and resonances.
#[derive(Debug, Clone)]
pub struct Growth {
    /// Amplitude of the excitation, drive units.
    pub amplitude: f64,
    /// Gain below the resonances relative to that at the first amplitude, real part of the projection.
    pub gain: f64,
    /// Standard error of `gain`, from its scatter over lines.
    pub gain_error: f64,
    /// Phase of that projection, rad: a loss is negative.
    pub phase_rad: f64,
    /// Frequencies of the resonances, Hz, in the order of their strength at the first amplitude.
    pub resonances_hz: Vec<f64>,
}

/// Follows gain and resonances over the responses at increasing amplitudes, all on the same lines.
pub fn growth(responses: &[(f64, Response)]) -> Vec<Growth> {
    let Some((_, first)) = responses.first() else { return Vec::new() };
    let reference = first.size();
    let peaks = strongest(&peaks(&reference), &reference);
    // Quasi-static: below a tenth of the lowest of the strongest resonances, where stiffness alone acts.
    let lowest = peaks.iter().copied().min().unwrap_or(reference.len());
    let limit = first.frequency_hz.get(lowest).map_or(f64::INFINITY, |f| 0.1 * f);
    let quiet: Vec<usize> = (0..reference.len()).filter(|&k| first.frequency_hz[k] < limit).collect();
    let per = first.gain.len() / reference.len().max(1);
    responses
        .iter()
        .map(|(amplitude, g)| {
            let ratio = |lines: &[usize]| -> Complex {
                let mut sum = Complex::ZERO;
                let mut power = 0.0;
                for &k in lines {
                    for i in k * per..(k + 1) * per {
                        sum += first.gain[i].conj() * g.gain[i];
                        power += first.gain[i].norm_sqr();
                    }
                }
                sum / power.max(f64::MIN_POSITIVE)
            };
            let whole = ratio(&quiet);
            let parts: Vec<f64> =
                quiet.chunks(quiet.len().div_ceil(12).max(1)).map(|c| ratio(c).re).collect();
            let count = parts.len().max(2) as f64;
            let variance = parts.iter().map(|r| (r - whole.re).powi(2)).sum::<f64>() / (count - 1.0);
            let now = g.size();
            let resonances_hz = peaks
                .iter()
                .map(|&k| {
                    let reach = (k / 20).max(REACH);
                    let range = k.saturating_sub(reach)..(k + reach + 1).min(now.len());
                    let top = range.max_by(|a, b| now[*a].total_cmp(&now[*b])).unwrap_or(k);
                    vertex(&g.frequency_hz, &now, top)
                })
                .collect();
            Growth {
                amplitude: *amplitude,
                gain: whole.re,
                gain_error: (variance / count).sqrt(),
                phase_rad: whole.arg(),
                resonances_hz,
            }
        })
        .collect()
}

/// Lines that are the largest within [`REACH`].
fn peaks(size: &[f64]) -> Vec<usize> {
    let last = size.len().saturating_sub(1);
    (1..last)
        .filter(|&k| {
            let near = k.saturating_sub(REACH)..=(k + REACH).min(last);
            near.clone().all(|j| size[j] <= size[k]) && size[k] > 0.0
        })
        .collect()
}

fn strongest(peaks: &[usize], size: &[f64]) -> Vec<usize> {
    let mut sorted = peaks.to_vec();
    sorted.sort_by(|a, b| size[*b].total_cmp(&size[*a]));
    sorted.truncate(RESONANCES);
    sorted
}

/// Vertex of the parabola through a peak and its neighbours on 1/|G|².
fn vertex(frequency: &[f64], size: &[f64], k: usize) -> f64 {
    if k == 0 || k + 1 >= size.len() {
        return frequency[k];
    }
    let inverse = |i: usize| 1.0 / size[i].max(f64::MIN_POSITIVE);
    let (a, b, c) = (inverse(k - 1), inverse(k), inverse(k + 1));
    let curvature = a - 2.0 * b + c;
    let shift = if curvature > 0.0 { (0.5 * (a - c) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
    frequency[k] + shift * (frequency[k + 1] - frequency[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_softer_and_stronger_resonator_is_recognised() {
        let lines: Vec<f64> = (1..=400).map(f64::from).collect();
        let resonator = |gain: f64, f0: f64| {
            let g = |f: &f64| gain / Complex::new(1.0 - (f / f0).powi(2), 0.02 * f / f0);
            Response {
                frequency_hz: lines.clone(),
                gain: lines.iter().map(g).collect(),
                power: vec![],
                residual: None,
                half_interval: None,
            }
        };
        let found = growth(&[(0.1, resonator(1.0, 200.3)), (0.3, resonator(1.1, 196.6))]);
        assert!((found[0].gain - 1.0).abs() < 1e-12);
        assert!((found[1].gain - 1.1).abs() < 0.01, "{}", found[1].gain);
        assert!((found[0].resonances_hz[0] - 200.3).abs() < 0.1);
        assert!((found[1].resonances_hz[0] - 196.6).abs() < 0.1);
    }
}
