//! A recording as experiments: spectra of drive and position on common lines.

use std::ops::Range;

use fitter::table::Values;
use numerics::fourier::{coefficients, hann};

use super::Complex;
use crate::thresholds::dynamic::spectrum::experiments::EXCITED;

/// One experiment's spectra, by line: drive `lines × inputs`, position `lines × outputs`.
#[derive(Debug, Clone)]
pub struct Experiment {
    /// Spectrum of the drives, drive units.
    pub drive: Vec<Complex>,
    /// Spectrum of the positions, position units.
    pub position: Vec<Complex>,
    /// Variance of `position` from the scatter over periods, where there are two or more; position units².
    pub noise: Option<Vec<f64>>,
    /// Factor of its residuals in a fit.
    pub weight: f64,
}

/// Experiments on common lines.
#[derive(Debug, Clone)]
pub struct Experiments {
    /// Number of drives.
    pub inputs: usize,
    /// Number of positions.
    pub outputs: usize,
    /// Time from one sample to the next, s.
    pub step_s: f64,
    /// Samples of a period or segment.
    pub length: usize,
    /// Number of each line: its frequency is `line / (length · step_s)`.
    pub lines: Vec<usize>,
    pub each: Vec<Experiment>,
}

impl Experiments {
    /// Frequency of every line, Hz.
    pub fn frequencies(&self) -> Vec<f64> {
        let unit = 1.0 / (self.length as f64 * self.step_s);
        self.lines.iter().map(|&k| k as f64 * unit).collect()
    }

    /// z = e^(iωT) of every line.
    pub fn points(&self) -> Vec<Complex> {
        let unit = std::f64::consts::TAU / self.length as f64;
        self.lines.iter().map(|&k| Complex::from_polar(1.0, unit * k as f64)).collect()
    }

    /// Of every experiment and position on a line the weighted power of what a response `gain` (outputs × inputs, by
    /// rows) leaves, and of the position.
    pub fn left<'a>(&'a self, line: usize, gain: &'a [Complex]) -> impl Iterator<Item = (f64, f64)> + 'a {
        let (m, p) = (self.inputs, self.outputs);
        self.each.iter().flat_map(move |e| {
            let (weight, drive) = (e.weight * e.weight, &e.drive[line * m..(line + 1) * m]);
            gain.chunks_exact(m).zip(&e.position[line * p..]).map(move |(gain, y)| {
                let predicted: Complex = gain.iter().zip(drive).map(|(g, u)| g * u).sum();
                (weight * (y - predicted).norm_sqr(), weight * y.norm_sqr())
            })
        })
    }
}

/// Spectra on some lines, by line and channel.
fn on_lines(lines: &[usize], spectra: &[Vec<Complex>]) -> Vec<Complex> {
    lines.iter().flat_map(|&k| spectra.iter().map(move |x| x[k])).collect()
}

/// Mean of the periods of `rows` of a channel: `length` samples.
pub fn mean_period(channel: &[f64], rows: &Range<usize>, length: usize) -> Vec<f64> {
    let periods = (rows.len() / length.max(1)).max(1);
    let mut mean = vec![0.0; length];
    for period in channel[rows.clone()].chunks_exact(length).take(periods) {
        for (m, v) in mean.iter_mut().zip(period) {
            *m += v / periods as f64;
        }
    }
    mean
}

/// Spectra of the mean period of a run, by channel.
pub fn period_spectra(channels: &[Values], run: &Range<usize>, length: usize) -> Vec<Vec<Complex>> {
    channels.iter().map(|c| coefficients(&mean_period(c, run, length))).collect()
}

/// Experiments of a periodic excitation in steady state: one for each run, averaged over the periods of
/// `length` samples that its rows hold, on the lines that any run excites.
pub fn periodic(
    drives: &[Values],
    positions: &[Values],
    runs: &[Range<usize>],
    length: usize,
    step_s: f64,
) -> Experiments {
    let drive: Vec<Vec<Vec<Complex>>> = runs.iter().map(|r| period_spectra(drives, r, length)).collect();
    let last = length.saturating_sub(1) / 2;
    let power: Vec<f64> =
        (0..=last).map(|k| drive.iter().flatten().map(|x| x[k].norm_sqr()).fold(0.0, f64::max)).collect();
    let strongest = power.iter().skip(1).copied().fold(0.0, f64::max);
    // The mean is no dynamics: line 0 is left out.
    let lines: Vec<usize> = (1..=last).filter(|&k| power[k] > EXCITED * strongest).collect();
    let each = runs
        .iter()
        .zip(&drive)
        .map(|(run, drive)| Experiment {
            drive: on_lines(&lines, drive),
            position: on_lines(&lines, &period_spectra(positions, run, length)),
            noise: period_noise(positions, run, length, &lines),
            weight: 1.0,
        })
        .collect();
    Experiments { inputs: drives.len(), outputs: positions.len(), step_s, length, lines, each }
}

/// Variance of the mean over periods, by line and output.
fn period_noise(
    positions: &[Values],
    run: &Range<usize>,
    length: usize,
    lines: &[usize],
) -> Option<Vec<f64>> {
    let periods = run.len() / length;
    if periods < 2 {
        return None;
    }
    let mut variance = vec![0.0; lines.len() * positions.len()];
    let scale = 1.0 / (periods * (periods - 1)) as f64;
    for (output, channel) in positions.iter().enumerate() {
        let mean = mean_period(channel, run, length);
        for period in channel[run.clone()].chunks_exact(length) {
            let rest: Vec<f64> = period.iter().zip(&mean).map(|(v, m)| v - m).collect();
            let spectrum = coefficients(&rest);
            for (line, &k) in lines.iter().enumerate() {
                variance[line * positions.len() + output] += scale * spectrum[k].norm_sqr();
            }
        }
    }
    Some(variance)
}

/// Experiments of any excitation: Hann-windowed segments of `length` samples, overlapping by half, their
/// means removed, of the rows of every run (Welch).
pub fn segments(
    drives: &[Values],
    positions: &[Values],
    runs: &[Range<usize>],
    length: usize,
    step_s: f64,
) -> Experiments {
    let window = hann(length);
    let spectra = |channels: &[Values], start: usize| -> Vec<Vec<Complex>> {
        channels
            .iter()
            .map(|c| {
                let part = &c[start..start + length];
                let mean = part.iter().sum::<f64>() / length as f64;
                coefficients(&part.iter().zip(&window).map(|(v, w)| (v - mean) * w).collect::<Vec<_>>())
            })
            .collect()
    };
    // The window smears the mean over two lines.
    let lines: Vec<usize> = (2..length / 2).collect();
    let mut each = Vec::new();
    for run in runs {
        let mut start = run.start;
        while start + length <= run.end {
            each.push(Experiment {
                drive: on_lines(&lines, &spectra(drives, start)),
                position: on_lines(&lines, &spectra(positions, start)),
                noise: None,
                weight: 1.0,
            });
            start += (length / 2).max(1);
        }
    }
    Experiments { inputs: drives.len(), outputs: positions.len(), step_s, length, lines, each }
}

/// A length of segments for runs of `rows` rows: a power of two, about sixteen of them to the run.
pub fn segment_length(rows: usize) -> usize {
    let most = (rows / 8).max(64);
    let power = 1usize << most.ilog2();
    power.min(8192)
}
