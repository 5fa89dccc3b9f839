//! The drive between its samples: held, straight, or band-limited.

use fitter::plant::Hold;
use motion::equations::Input;
use motion::signal::{Edge, STRETCHES, band_limited_cubics, band_limited_parabolas};
use physics::number::Number;

use super::span::Span;
use super::turns::Turns;

/// The drive of one run as a function of time: on every interval a cubic a + b s + c s² + d s³ of the part
/// s of the interval that has passed, or several in a row. It may begin before the run's first row.
#[derive(Debug, Clone)]
pub struct Signal {
    cubics: Vec<[f64; 4]>,
    /// Cubics of an interval.
    each: usize,
    /// Intervals before the first row.
    lead: usize,
    step_s: f64,
}

/// A stretch on which the drive is one cubic.
#[derive(Debug, Clone, Copy)]
pub struct Piece<T> {
    /// Its coefficients along the stretch, from 0 to 1.
    pub cubic: [T; 4],
    /// Length, as a part of the step that was asked for.
    pub part: T,
}

impl Signal {
    /// The drive through `samples`, `step_s` apart, of which the first `lead` come before the run.
    pub fn new(samples: &[f64], lead: usize, step_s: f64, hold: Hold) -> Signal {
        let n = samples.len();
        let next = |k: usize| samples[(k + 1).min(n - 1)];
        let cubics: Vec<[f64; 4]> = match hold {
            Hold::ZeroOrder => samples.iter().map(|u| [*u, 0.0, 0.0, 0.0]).collect(),
            Hold::FirstOrder => (0..n).map(|k| [samples[k], next(k) - samples[k], 0.0, 0.0]).collect(),
            Hold::BandLimited => {
                let mut cubics = band_limited_cubics(samples, Edge::Reflected);
                cubics.extend(samples.last().map(|last| [*last, 0.0, 0.0, 0.0]));
                cubics
            }
        };
        Signal { cubics, each: 1, lead, step_s }
    }

    /// A band-limited one by as many parabolas as a hysteresis or a limit needs.
    pub fn fine(samples: &[f64], lead: usize, step_s: f64) -> Signal {
        let mut cubics = band_limited_parabolas(samples, Edge::Reflected);
        cubics.extend(samples.last().into_iter().flat_map(|last| [[*last, 0.0, 0.0, 0.0]; STRETCHES]));
        Signal { cubics, each: STRETCHES, lead, step_s }
    }

    /// The part of it on some intervals of the run, with at most `lead` before them.
    pub fn part(&self, range: std::ops::Range<usize>, lead: usize) -> Signal {
        let start = self.lead + range.start;
        let lead = lead.min(start);
        let cubics = self.cubics[self.each * (start - lead)..self.each * (self.lead + range.end)].to_vec();
        Signal { cubics, lead, ..*self }
    }

    /// Intervals from the first row on.
    pub fn intervals(&self) -> usize {
        self.cubics.len() / self.each - self.lead
    }

    /// Shows a hysteresis the drive along some intervals.
    pub fn pass(&self, intervals: std::ops::Range<usize>, turns: &mut Turns<f64>) {
        let [from, to] = [intervals.start, intervals.end].map(|k| self.each * (self.lead + k));
        for cubic in &self.cubics[from..to] {
            let at = |r: f64| along(*cubic, r, 0.0)[0];
            Span { from: at(0.0), middle: at(0.5), to: at(1.0) }.remembered(turns);
        }
    }

    /// Cubic `k` of the run; before the start and after the end the drive stands still.
    fn cubic(&self, k: isize) -> [f64; 4] {
        let last = self.cubics.len() as isize - 1;
        let k = k + (self.each * self.lead) as isize;
        match k {
            _ if k < 0 => [self.cubics[0][0], 0.0, 0.0, 0.0],
            _ if k >= last => [self.cubics[last as usize][0], 0.0, 0.0, 0.0],
            _ => self.cubics[k as usize],
        }
    }

    /// The drive on a part of interval `k`, from `s` on, where that is one cubic.
    #[inline]
    pub fn whole(&self, k: isize, s: f64, part: f64) -> Option<[f64; 4]> {
        if self.each > 1 {
            return None;
        }
        let cubic = self.cubics[(k + self.lead as isize) as usize];
        Some(if part == 1.0 { cubic } else { along(cubic, s, part) })
    }

    /// The drive on the same part, `delay_s` earlier: what it runs through there, with what follows from the
    /// delay's derivatives.
    pub fn pieces<T: Number>(
        &self,
        k: isize,
        s: f64,
        part: f64,
        delay_s: Option<T>,
    ) -> impl Iterator<Item = Piece<T>> {
        let each = self.each as f64;
        let begin = T::from_f64((k as f64 + s) * each);
        // After whole steps the stretch before has no length yet, but begins to have one: a held drive jumps there.
        let (begin, first) = match delay_s {
            Some(delay_s) => {
                let begin = begin - delay_s * (each / self.step_s);
                (begin, begin.value().ceil() - 1.0)
            }
            None => (begin, begin.value().floor()),
        };
        let into = begin - T::from_f64(first);
        let end = into + T::from_f64(part * each);
        let count = end.value().ceil() as usize;
        (0..count).map(move |i| {
            let from = if i == 0 { into } else { T::from_f64(0.0) };
            let to = if i + 1 == count { end - T::from_f64(i as f64) } else { T::from_f64(1.0) };
            let cubic = self.cubic(first as isize + i as isize).map(T::from_f64);
            Piece { cubic: along(cubic, from, to - from), part: (to - from) * (1.0 / (part * each)) }
        })
    }
}

impl Input for Signal {
    fn piece(&self, within_s: f64) -> motion::equations::Piece {
        let length_s = self.step_s / self.each as f64;
        let index = (within_s / length_s).floor();
        let cubic = self.cubic(index as isize);
        motion::equations::Piece { from_s: index * length_s, per_s: 1.0 / length_s, cubic }
    }
}

/// A cubic along a part of its way, from `s` on.
pub fn along<T: Number>([a, b, c, d]: [T; 4], s: T, length: T) -> [T; 4] {
    let square = length * length;
    [
        a + s * (b + s * (c + s * d)),
        length * (b + s * (c * 2.0 + s * d * 3.0)),
        square * (c + s * d * 3.0),
        square * length * d,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::number::Dual;

    fn sine(n: usize) -> Vec<f64> {
        (0..n).map(|k| (0.4 * k as f64).sin()).collect()
    }

    fn at<T: Number>(cubic: [T; 4], r: f64) -> T {
        along(cubic, T::from_f64(r), T::from_f64(1.0))[0]
    }

    #[test]
    fn a_delay_shifts_and_knows_its_slope() {
        for hold in [Hold::ZeroOrder, Hold::FirstOrder, Hold::BandLimited] {
            let signal = Signal::new(&sine(60), 7, 0.5, hold);
            // The mean over a step, which is what moves the mechanism.
            fn mean<T: Number>(signal: &Signal, delay: T) -> T {
                let simpson = |p: Piece<T>| {
                    p.part * (at(p.cubic, 0.0) + at(p.cubic, 0.5) * 4.0 + at(p.cubic, 1.0)) * (1.0 / 6.0)
                };
                signal.pieces(20, 0.25, 0.5, Some(delay)).fold(T::from_f64(0.0), |sum, p| sum + simpson(p))
            }
            let slope = mean(&signal, Dual::<1>::variable(0.31, 0)).slopes[0];
            let quotient = (mean(&signal, 0.31 + 1e-6) - mean(&signal, 0.31 - 1e-6)) / 2e-6;
            assert!((slope - quotient).abs() < 1e-5, "{hold:?}: {slope} {quotient}");
            // After whole steps a stretch without length comes first.
            let [none, whole] = signal.pieces(20, 0.0, 1.0, Some(0.5)).collect::<Vec<_>>()[..] else {
                panic!()
            };
            assert_eq!(none.part, 0.0);
            assert!((whole.cubic[0] - sine(60)[7 + 19]).abs() < 1e-12);
            assert!(signal.pieces(0, 0.0, 1.0, Some(20.0)).all(|piece| piece.cubic[0] == sine(60)[0]));
        }
    }

    #[test]
    fn a_delay_that_begins_has_the_slope_of_a_drive_that_jumps() {
        let signal = Signal::new(&sine(60), 7, 0.5, Hold::ZeroOrder);
        let pieces = signal.pieces(20, 0.0, 1.0, Some(Dual::<1>::variable(0.0, 0)));
        let slope: f64 = pieces.map(|p| (p.part * p.cubic[0]).slopes[0]).sum();
        let jump = sine(60)[7 + 20] - sine(60)[7 + 19];
        assert!((slope + jump / 0.5).abs() < 1e-12, "{slope} {jump}");
    }
}
