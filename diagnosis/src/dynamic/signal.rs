//! The drive between its samples: held, straight, or band-limited by a cubic spline.

use fitter::plant::Hold;

use super::number::Number;

/// The drive of one run as a function of time: on every interval a cubic a + b s + c s² + d s³ of the part
/// s of the interval that has passed.
#[derive(Debug, Clone)]
pub struct Signal {
    cubics: Vec<[f64; 4]>,
    /// Integral from the start to the beginning of every interval, in samples; where the drive is held.
    sums: Option<Vec<f64>>,
    step_s: f64,
}

impl Signal {
    /// The drive through `samples`, `step_s` apart.
    pub fn new(samples: &[f64], step_s: f64, hold: Hold) -> Signal {
        let n = samples.len();
        let next = |k: usize| samples[(k + 1).min(n - 1)];
        let cubics: Vec<[f64; 4]> = match hold {
            Hold::ZeroOrder => samples.iter().map(|u| [*u, 0.0, 0.0, 0.0]).collect(),
            Hold::FirstOrder => (0..n).map(|k| [samples[k], next(k) - samples[k], 0.0, 0.0]).collect(),
            Hold::BandLimited => spline(samples),
        };
        let sums = (hold == Hold::ZeroOrder).then(|| {
            let mut sum = 0.0;
            samples
                .iter()
                .map(|u| {
                    let before = sum;
                    sum += u;
                    before
                })
                .collect()
        });
        Signal { cubics, sums, step_s }
    }

    /// The part of it on some intervals.
    pub fn part(&self, range: std::ops::Range<usize>) -> Signal {
        let sums = self
            .sums
            .as_ref()
            .map(|sums| sums[range.clone()].iter().map(|s| s - sums[range.start]).collect());
        Signal { cubics: self.cubics[range].to_vec(), sums, step_s: self.step_s }
    }

    /// Value at the part `s` of interval `k`.
    #[inline]
    pub fn at(&self, k: usize, s: f64) -> f64 {
        let [a, b, c, d] = self.cubics[k];
        a + s * (b + s * (c + s * d))
    }

    /// Value and slope (per sample) at `x` samples from the start; before the start and after the end it
    /// stands still.
    fn anywhere(&self, x: f64) -> (f64, f64) {
        let last = self.cubics.len() - 1;
        if x <= 0.0 {
            return (self.cubics[0][0], 0.0);
        }
        if x >= last as f64 {
            return (self.cubics[last][0], 0.0);
        }
        let k = x as usize;
        let s = x - k as f64;
        let [a, b, c, d] = self.cubics[k];
        (a + s * (b + s * (c + s * d)), b + s * (2.0 * c + s * 3.0 * d))
    }

    /// Integral from the start to `x`, in samples, of a drive that is held.
    fn integral(&self, sums: &[f64], x: f64) -> f64 {
        let last = self.cubics.len() - 1;
        if x <= 0.0 {
            return x * self.cubics[0][0];
        }
        let k = (x as usize).min(last);
        sums[k] + (x - k as f64) * self.cubics[k][0]
    }

    /// The drive at the part `s` of interval `k`, `delay_s` earlier. A held drive jumps, and how a
    /// simulation depends on where would be lost: it is averaged over `width`, a part of an interval.
    pub fn delayed<T: Number>(&self, k: usize, s: f64, delay_s: T, width: f64) -> T {
        let x = k as f64 + s - delay_s.value() / self.step_s;
        let (value, slope) = match &self.sums {
            None => self.anywhere(x),
            Some(sums) => {
                let half = 0.5 * width;
                let mean = (self.integral(sums, x + half) - self.integral(sums, x - half)) / width;
                (mean, (self.anywhere(x + half).0 - self.anywhere(x - half).0) / width)
            }
        };
        delay_s.chain(value, -slope / self.step_s)
    }
}

/// The natural cubic spline; what its ends are wrong by has died out after a few samples.
fn spline(samples: &[f64]) -> Vec<[f64; 4]> {
    let n = samples.len();
    if n < 3 {
        return samples.iter().map(|u| [*u, 0.0, 0.0, 0.0]).collect();
    }
    // Second derivatives m: m[k−1] + 4 m[k] + m[k+1] = 6 (u[k−1] − 2 u[k] + u[k+1]), m = 0 at the ends.
    let mut second = vec![0.0; n];
    let mut upper = vec![0.0; n];
    for k in 1..n - 1 {
        let right = 6.0 * (samples[k - 1] - 2.0 * samples[k] + samples[k + 1]);
        let pivot = 4.0 - upper[k - 1];
        upper[k] = 1.0 / pivot;
        second[k] = (right - second[k - 1]) / pivot;
    }
    for k in (1..n - 1).rev() {
        second[k] -= upper[k] * second[k + 1];
    }
    (0..n)
        .map(|k| {
            if k + 1 == n {
                return [samples[k], 0.0, 0.0, 0.0];
            }
            let (m0, m1) = (second[k], second[k + 1]);
            let rise = samples[k + 1] - samples[k];
            [samples[k], rise - (2.0 * m0 + m1) / 6.0, 0.5 * m0, (m1 - m0) / 6.0]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamic::number::Dual;

    fn sine(n: usize) -> Vec<f64> {
        (0..n).map(|k| (0.4 * k as f64).sin()).collect()
    }

    #[test]
    fn a_spline_follows_a_sine_between_its_samples() {
        let signal = Signal::new(&sine(60), 1.0, Hold::BandLimited);
        for k in 10..50 {
            let x = k as f64 + 0.5;
            assert!((signal.at(k, 0.5) - (0.4 * x).sin()).abs() < 2e-4);
        }
    }

    #[test]
    fn a_delay_shifts_and_knows_its_slope() {
        for hold in [Hold::ZeroOrder, Hold::FirstOrder, Hold::BandLimited] {
            let signal = Signal::new(&sine(60), 0.5, hold);
            let at = |delay: f64| signal.delayed(20, 0.25, delay, 0.25);
            let slope = signal.delayed(20, 0.25, Dual::<1>::variable(0.31, 0), 0.25).slopes[0];
            let quotient = (at(0.31 + 1e-6) - at(0.31 - 1e-6)) / 2e-6;
            assert!((slope - quotient).abs() < 1e-5, "{hold:?}: {slope} {quotient}");
        }
        let signal = Signal::new(&sine(60), 0.5, Hold::BandLimited);
        assert!((signal.delayed(20, 0.0, 0.5, 0.25) - sine(60)[19]).abs() < 1e-12);
    }
}
