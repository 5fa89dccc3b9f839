//! A drive between its samples: held, straight, or band-limited.

use fitter::plant::Hold;

use crate::equations::Piece;

/// Values of a drive per sample interval, as cubic pieces of equal length.
#[derive(Debug, Clone)]
pub struct Signal {
    hold: Hold,
    start_s: f64,
    piece_s: f64,
    /// Coefficients of 1, s, s², s³ with s from 0 to 1 along the piece.
    pieces: Vec<[f64; 4]>,
}

/// A quantity and its rate of change per second.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// The value.
    pub value: f64,
    /// Its time derivative.
    pub rate: f64,
}

/// What a band-limited drive is before its first and after its last sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// It goes on periodically.
    Periodic,
    /// Not known: it is continued by its reflection through the end point.
    Reflected,
}

/// Pieces per sample of a band-limited drive: a cubic through eight-fold oversampled values departs from the
/// band-limited signal by 10⁻⁴ of the amplitude just below half the sampling rate, by far less lower down.
const OVERSAMPLING: usize = 8;
/// Samples on either side that the windowed sinc reaches.
const REACH: isize = 24;
/// Shape of Kaiser's window; 80 dB beyond its transition.
const KAISER: f64 = 8.0;

impl Signal {
    /// The drive that has `samples` at `start_s`, `start_s + sample_s`, …
    pub fn new(samples: &[f64], start_s: f64, sample_s: f64, hold: Hold, edge: Edge) -> Signal {
        match hold {
            Hold::ZeroOrder => {
                let pieces = samples.iter().map(|&u| [u, 0.0, 0.0, 0.0]).collect();
                Signal { hold, start_s, piece_s: sample_s, pieces }
            }
            Hold::FirstOrder => {
                let next = |i: usize| samples.get(i + 1).copied().unwrap_or(samples[i]);
                let pieces =
                    (0..samples.len()).map(|i| [samples[i], next(i) - samples[i], 0.0, 0.0]).collect();
                Signal { hold, start_s, piece_s: sample_s, pieces }
            }
            Hold::BandLimited => {
                let dense = oversampled(samples, edge);
                let pieces = cubic_pieces(&dense);
                Signal { hold, start_s, piece_s: sample_s / OVERSAMPLING as f64, pieces }
            }
        }
    }

    /// A drive that is held from sample to sample and grows by [`push`](Self::push).
    pub fn held(sample_s: f64) -> Signal {
        Signal { hold: Hold::ZeroOrder, start_s: 0.0, piece_s: sample_s, pieces: Vec::new() }
    }

    /// The next sample of a held drive.
    pub fn push(&mut self, value: f64) {
        self.pieces.push([value, 0.0, 0.0, 0.0]);
    }

    /// Whether it bends or jumps at every sample, so that an integration has to pause there.
    pub fn breaks(&self) -> bool {
        self.hold != Hold::BandLimited
    }

    /// Length of a piece, s: along it the drive is one cubic.
    pub fn piece_s(&self) -> f64 {
        self.piece_s
    }

    /// Value and rate at `time_s`, taken from the piece that `within_s` lies in: at a sample the limit from
    /// that side. Before the first sample and after the last it stands still.
    pub fn at(&self, time_s: f64, within_s: f64) -> Flow {
        let piece = self.piece(within_s);
        Flow { value: piece.value(time_s), rate: piece.rate(time_s) }
    }

    /// The piece that `within_s` lies in.
    pub fn piece(&self, within_s: f64) -> Piece {
        let index = ((within_s - self.start_s) / self.piece_s).floor();
        let standing = |value: f64| [value, 0.0, 0.0, 0.0];
        let cubic = match self.pieces.get(index.max(0.0) as usize) {
            Some(piece) if index < 0.0 => standing(piece[0]),
            Some(piece) => *piece,
            None => standing(self.pieces.last().map_or(0.0, |[a, b, c, d]| a + b + c + d)),
        };
        Piece { from_s: self.start_s + index * self.piece_s, per_s: 1.0 / self.piece_s, cubic }
    }
}

/// Sample `index` of a signal that is continued beyond its ends.
fn continued(samples: &[f64], index: isize, edge: Edge) -> f64 {
    let count = samples.len() as isize;
    let inside = |index: isize| samples[index.clamp(0, count - 1) as usize];
    match edge {
        Edge::Periodic => samples[index.rem_euclid(count) as usize],
        Edge::Reflected if index < 0 => 2.0 * inside(0) - inside(-index),
        Edge::Reflected if index >= count => 2.0 * inside(count - 1) - inside(2 * (count - 1) - index),
        Edge::Reflected => inside(index),
    }
}

/// The band-limited signal at eight times the rate, by a sinc in Kaiser's window (Oppenheim and Schafer,
/// *Discrete-Time Signal Processing*, section 7.5), up to one sample after the last, and its slopes there.
fn oversampled(samples: &[f64], edge: Edge) -> Vec<f64> {
    let count = samples.len() as isize;
    let kernels: Vec<Vec<f64>> = (0..OVERSAMPLING)
        .map(|part| {
            let offset = part as f64 / OVERSAMPLING as f64;
            let weights: Vec<f64> = (-REACH + 1..=REACH).map(|j| windowed_sinc(offset - j as f64)).collect();
            // A constant stays what it is.
            let sum: f64 = weights.iter().sum();
            weights.iter().map(|weight| weight / sum).collect()
        })
        .collect();
    let mut dense = Vec::with_capacity((samples.len() + 1) * OVERSAMPLING);
    for index in 0..=count {
        let near: Vec<f64> = (-REACH + 1..=REACH).map(|j| continued(samples, index + j, edge)).collect();
        for (part, kernel) in kernels.iter().enumerate() {
            dense.push(match part {
                0 => near[REACH as usize - 1],
                _ => kernel.iter().zip(&near).map(|(weight, value)| weight * value).sum(),
            });
        }
    }
    dense
}

fn windowed_sinc(x: f64) -> f64 {
    let place = x / REACH as f64;
    if place.abs() >= 1.0 {
        return 0.0;
    }
    let angle = std::f64::consts::PI * x;
    let sinc = if x == 0.0 { 1.0 } else { angle.sin() / angle };
    sinc * bessel_i0(KAISER * (1.0 - place * place).sqrt()) / bessel_i0(KAISER)
}

/// The modified Bessel function I₀ by its power series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..60 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

/// A band-limited drive by one cubic per interval between its samples, one fewer than these: coefficients of 1, s, s², s³ with
/// s from 0 to 1, in the unit of the drive. Each goes through the samples at its ends and has the area and the first moment of
/// the windowed sinc; a mechanism that is slow beside the interval responds to these alone.
pub fn band_limited_cubics(samples: &[f64], edge: Edge) -> Vec<[f64; 4]> {
    if samples.is_empty() {
        return Vec::new();
    }
    let dense = oversampled(samples, edge);
    (0..samples.len() - 1)
        .map(|k| {
            let values = &dense[k * OVERSAMPLING..=(k + 1) * OVERSAMPLING];
            let (from, rise) = (values[0], values[OVERSAMPLING] - values[0]);
            // What departs from the chord, by Simpson's rule, is s (1 − s) (α + β (2 s − 1)).
            let (mut area, mut moment) = (0.0, 0.0);
            for (i, value) in values.iter().enumerate().take(OVERSAMPLING).skip(1) {
                let s = i as f64 / OVERSAMPLING as f64;
                let weight = if i % 2 == 1 { 4.0 } else { 2.0 } / (3 * OVERSAMPLING) as f64;
                area += weight * (value - from - rise * s);
                moment += weight * (value - from - rise * s) * (s - 0.5);
            }
            let (alpha, beta) = (6.0 * area, 60.0 * moment);
            [from, rise + alpha - beta, 3.0 * beta - alpha, -2.0 * beta]
        })
        .collect()
}

/// Stretches of every interval of [`band_limited_parabolas`].
pub const STRETCHES: usize = OVERSAMPLING / 2;

/// The windowed sinc itself, by [`STRETCHES`] parabolas per interval, in the form of [`band_limited_cubics`]: for what has to see
/// how far the drive goes between its samples, as a hysteresis or a limit does.
pub fn band_limited_parabolas(samples: &[f64], edge: Edge) -> Vec<[f64; 4]> {
    let dense = if samples.is_empty() { Vec::new() } else { oversampled(samples, edge) };
    let count = samples.len().saturating_sub(1) * STRETCHES;
    let through = |v: &[f64]| [v[0], 4.0 * v[1] - 3.0 * v[0] - v[2], 2.0 * (v[0] + v[2] - 2.0 * v[1]), 0.0];
    (0..count).map(|k| through(&dense[2 * k..=2 * k + 2])).collect()
}

/// Cubic pieces through the values with slopes of sixth order at each.
fn cubic_pieces(values: &[f64]) -> Vec<[f64; 4]> {
    let last = values.len() - 1;
    let slope = |i: usize| {
        let at = |offset: isize| {
            let index = i as isize + offset;
            // Beyond the ends by reflection, which keeps the slope at the end.
            match index {
                index if index < 0 => 2.0 * values[0] - values[index.unsigned_abs().min(last)],
                index if index > last as isize => {
                    2.0 * values[last] - values[(2 * last as isize - index).max(0) as usize]
                }
                index => values[index as usize],
            }
        };
        (45.0 * (at(1) - at(-1)) - 9.0 * (at(2) - at(-2)) + (at(3) - at(-3))) / 60.0
    };
    let slopes: Vec<f64> = (0..values.len()).map(slope).collect();
    values
        .windows(2)
        .zip(slopes.windows(2))
        .map(|(v, m)| {
            let rise = v[1] - v[0];
            [v[0], m[0], 3.0 * rise - 2.0 * m[0] - m[1], m[0] + m[1] - 2.0 * rise]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_drive_jumps_and_a_straight_one_bends_at_its_samples() {
        let samples = [1.0, 3.0, 2.0];
        let held = Signal::new(&samples, 0.0, 0.5, Hold::ZeroOrder, Edge::Reflected);
        assert_eq!(held.at(0.5, 0.25), Flow { value: 1.0, rate: 0.0 });
        assert_eq!(held.at(0.5, 0.75), Flow { value: 3.0, rate: 0.0 });
        let straight = Signal::new(&samples, 0.0, 0.5, Hold::FirstOrder, Edge::Reflected);
        assert_eq!(straight.at(0.5, 0.25), Flow { value: 3.0, rate: 4.0 });
        assert_eq!(straight.at(0.5, 0.75), Flow { value: 3.0, rate: -2.0 });
        assert_eq!(straight.at(-1.0, -1.0).value, 1.0);
        assert_eq!(straight.at(9.0, 9.0).value, 2.0);
    }

    #[test]
    fn one_cubic_per_interval_has_the_area_and_the_moment_of_the_sine() {
        let omega = std::f64::consts::TAU * 0.35;
        let samples: Vec<f64> = (0..200).map(|k| (omega * f64::from(k)).sin()).collect();
        let cubics = band_limited_cubics(&samples, Edge::Reflected);
        assert_eq!(cubics.len(), 199);
        for (k, [a, b, c, d]) in cubics.into_iter().enumerate().take(150).skip(50) {
            assert_eq!(a, samples[k]);
            assert!((a + b + c + d - samples[k + 1]).abs() < 1e-12);
            let [from, to] = [k as f64, k as f64 + 1.0].map(|t| omega * t);
            let area = (from.cos() - to.cos()) / omega;
            assert!((a + b / 2.0 + c / 3.0 + d / 4.0 - area).abs() < 2e-4, "{k}");
            // The integral of s sin ω(k + s), by parts.
            let moment = (to.sin() - from.sin()) / (omega * omega) - to.cos() / omega;
            assert!((a / 2.0 + b / 3.0 + c / 4.0 + d / 5.0 - moment).abs() < 2e-4, "{k}");
        }
        assert!(band_limited_cubics(&[], Edge::Reflected).is_empty());
    }

    #[test]
    fn parabolas_go_as_far_between_the_samples_as_the_sine() {
        let omega = std::f64::consts::TAU * 0.35;
        let samples: Vec<f64> = (0..200).map(|k| (omega * f64::from(k)).sin()).collect();
        let parabolas = band_limited_parabolas(&samples, Edge::Reflected);
        assert_eq!(parabolas.len(), 199 * STRETCHES);
        for (k, [a, b, c, _]) in parabolas.into_iter().enumerate().take(150 * STRETCHES).skip(50 * STRETCHES)
        {
            for part in [0.0, 0.25, 0.5, 1.0] {
                let sine = (omega * (k as f64 + part) / STRETCHES as f64).sin();
                assert!((a + part * (b + part * c) - sine).abs() < 2e-3, "{k} {part}");
            }
        }
        assert!(band_limited_parabolas(&[], Edge::Reflected).is_empty());
    }

    #[test]
    fn a_band_limited_drive_is_the_sine_that_was_sampled() {
        // 0.35 of the sampling rate: a cubic spline through the samples would be wrong by several per cent.
        let frequency = 0.35;
        let sine = |t: f64| (std::f64::consts::TAU * frequency * t + 0.3).sin();
        let samples: Vec<f64> = (0..400).map(|k| sine(f64::from(k))).collect();
        for edge in [Edge::Reflected, Edge::Periodic] {
            let signal = Signal::new(&samples, 0.0, 1.0, Hold::BandLimited, edge);
            let worst = (0..3000)
                .map(|k| 50.0 + 0.1 * f64::from(k))
                .map(|t| (signal.at(t, t).value - sine(t)).abs())
                .fold(0.0, f64::max);
            // 80 dB of the window.
            assert!(worst < 2e-4, "{worst}");
        }
        // 400 · 0.35 is a whole number of periods, so that the periodic one is right at its edges too.
        let signal = Signal::new(&samples, 0.0, 1.0, Hold::BandLimited, Edge::Periodic);
        assert!((signal.at(0.5, 0.5).value - sine(0.5)).abs() < 2e-4);
        assert!((signal.at(399.5, 399.5).value - sine(399.5)).abs() < 2e-4);
    }
}
