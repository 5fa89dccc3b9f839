//! Whitening by the Kalman filter of a [`Process`]: what is new in every reading beyond what the earlier ones foretell. One
//! pass over the rows, whatever their times, with one state for each part of the process.

use std::sync::Arc;

use numerics::{Columns, median};
use pulp::{Arch, Simd, WithSimd};

use super::Process;

/// Columns that are made white together: the steps of a row take as long as so many additions.
const ABREAST: usize = 8;

/// The filter of a process at the times of a recording.
#[derive(Debug, Clone)]
pub struct Correlation {
    /// Time since the previous row in typical gaps; the first row has none.
    gaps: Arc<[f64]>,
    process: Process,
    /// Standard deviation of what is new in every row.
    new: Vec<f64>,
    /// Row by row for every part: what is left of it since the row before, and how much of what is new it takes over.
    left: Vec<f64>,
    gain: Vec<f64>,
}

impl Correlation {
    /// Uncorrelated readings at these times (seconds, not decreasing).
    pub fn none(t_s: &[f64]) -> Correlation {
        let mut steps: Vec<f64> = t_s.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
        let typical = median(&mut steps).max(1e-12);
        let gap = |w: &[f64]| ((w[1] - w[0]) / typical).max(1e-3);
        let gaps = std::iter::once(f64::INFINITY).chain(t_s.windows(2).map(gap)).collect();
        Correlation::of(gaps, Process::white())
    }

    /// The same readings, of this process.
    pub fn with(&self, process: &Process) -> Correlation {
        Correlation::of(Arc::clone(&self.gaps), process.clone())
    }

    fn of(gaps: Arc<[f64]>, process: Process) -> Correlation {
        let (n, parts) = (gaps.len(), process.parts.len());
        let (mut new, mut left, mut gain) = (Vec::with_capacity(n), Vec::new(), Vec::new());
        left.reserve(n * parts);
        gain.reserve(n * parts);
        // Covariance of the parts, given the rows up to the last.
        let mut known = vec![0.0; parts * parts];
        for gap in gaps.iter() {
            let factors: Vec<f64> = process.parts.iter().map(|(_, time)| (-gap / time).exp()).collect();
            for (j, (part, _)) in process.parts.iter().enumerate() {
                for l in 0..parts {
                    known[j * parts + l] *= factors[j] * factors[l];
                }
                known[j * parts + j] += part * (1.0 - factors[j] * factors[j]);
            }
            let with_all: Vec<f64> = known.chunks(parts.max(1)).map(|row| row.iter().sum()).collect();
            let variance = (process.new + with_all.iter().sum::<f64>()).max(f64::MIN_POSITIVE);
            for j in 0..parts {
                for l in 0..parts {
                    known[j * parts + l] -= with_all[j] * with_all[l] / variance;
                }
            }
            new.push(variance.sqrt());
            left.extend(factors);
            gain.extend(with_all.into_iter().take(parts).map(|c| c / variance));
        }
        Correlation { gaps, process, new, left, gain }
    }

    /// The process.
    pub fn process(&self) -> &Process {
        &self.process
    }

    /// From the first row to the last, in typical gaps.
    pub fn duration(&self) -> f64 {
        self.gaps.iter().skip(1).sum()
    }

    /// Correlation of readings one typical gap apart.
    pub fn typical(&self) -> f64 {
        self.process.after(1.0)
    }

    /// ln det of the correlation matrix.
    pub fn log_determinant(&self) -> f64 {
        2.0 * self.new.iter().map(|s| s.ln()).sum::<f64>()
    }

    /// Makes values of this process white, of the same variance.
    pub fn whiten(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        // Nearly every process has one part or none: their state is kept in a register.
        match self.process.parts.len() {
            0 => values.zip(&self.new).map(|(v, new)| v / new).collect(),
            1 => self.whiten_from([0.0], values),
            parts => self.whiten_from(vec![0.0; parts], values),
        }
    }

    /// The same of columns.
    pub fn whitened(&self, columns: &Columns) -> Columns {
        let mut white = Columns::new(columns.rows);
        white.reserve(columns.count() + 1);
        let all = (0..columns.count()).map(|k| columns.get(k));
        self.whitener(&vec![1.0; columns.rows]).whiten_onto(all, &mut white);
        white
    }

    /// The same from a state of nothing.
    fn whiten_from(&self, mut state: impl AsMut<[f64]>, values: impl Iterator<Item = f64>) -> Vec<f64> {
        values
            .enumerate()
            .map(|(i, v)| self.step(i, state.as_mut(), |expected| v - expected) / self.new[i])
            .collect()
    }

    /// Makes white values of this process: the inverse of [`Correlation::whiten`].
    pub fn colour(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut state = vec![0.0; self.process.parts.len()];
        let mut at = 0.0;
        let mut next = |(i, w): (usize, f64)| {
            let new = self.step(i, &mut state, |expected| {
                at = expected;
                w * self.new[i]
            });
            at + new
        };
        values.enumerate().map(&mut next).collect()
    }

    /// Moves the state on to row `i` and takes over what is new there, which follows from what was expected.
    #[inline(always)]
    fn step(&self, i: usize, state: &mut [f64], new: impl FnOnce(f64) -> f64) -> f64 {
        let here = i * state.len()..(i + 1) * state.len();
        let mut expected = 0.0;
        for (m, left) in state.iter_mut().zip(&self.left[here.clone()]) {
            *m *= left;
            expected += *m;
        }
        let new = new(expected);
        state.iter_mut().zip(&self.gain[here]).for_each(|(m, gain)| *m += gain * new);
        new
    }

    /// The transpose of [`Correlation::whiten`].
    pub fn whiten_transposed(&self, values: &[f64]) -> Vec<f64> {
        self.transposed(values.len(), |i, later| {
            let new = values[i] / self.new[i] + later;
            (new, -new)
        })
    }

    /// The transpose of [`Correlation::colour`].
    pub fn colour_transposed(&self, values: &[f64]) -> Vec<f64> {
        self.transposed(values.len(), |i, later| (self.new[i] * (values[i] + later), values[i]))
    }

    /// Passes what the later rows ask of the state back through the rows: `row` gives, from what they ask of a row's new
    /// part, the row's value and what it asks of the state that was expected.
    fn transposed(&self, n: usize, row: impl Fn(usize, f64) -> (f64, f64)) -> Vec<f64> {
        let parts = self.process.parts.len();
        let mut asked = vec![0.0; parts];
        let mut out = vec![0.0; n];
        for i in (0..n).rev() {
            let here = i * parts..(i + 1) * parts;
            let later: f64 = asked.iter().zip(&self.gain[here.clone()]).map(|(a, gain)| a * gain).sum();
            let (value, expected) = row(i, later);
            out[i] = value;
            asked.iter_mut().zip(&self.left[here]).for_each(|(a, left)| *a = left * (*a + expected));
        }
        out
    }

    /// What makes values white whose rows have these standard deviations.
    pub fn whitener(&self, sigma: &[f64]) -> Whitener {
        Whitener(Arc::new((self.clone(), sigma.iter().map(|s| 1.0 / s).collect())))
    }
}

/// Some columns made white at once by the filter of a process with one part, in the widest registers that the processor has.
struct WhitenAbreast<'a> {
    filter: &'a Correlation,
    /// 1/σ of every row.
    inverse: &'a [f64],
    columns: &'a [&'a [f64]; ABREAST],
    /// Where they are written, one after another.
    room: &'a mut [f64],
}

impl WithSimd for WhitenAbreast<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n = self.inverse.len();
        let Correlation { new, left, gain, .. } = self.filter;
        let mut state = [0.0; ABREAST];
        let of_rows = self.inverse.iter().zip(new).zip(left.iter().zip(gain));
        for (i, ((inverse, new), (left, gain))) in of_rows.enumerate() {
            let read: [f64; ABREAST] = std::array::from_fn(|k| self.columns[k][i]);
            let mut white = [0.0; ABREAST];
            for k in 0..ABREAST {
                state[k] *= left;
                let found = read[k] * inverse - state[k];
                state[k] += gain * found;
                white[k] = found / new;
            }
            for (k, white) in white.iter().enumerate() {
                self.room[k * n + i] = *white;
            }
        }
    }
}

/// Makes noise white, of variance one: each row divided by its σ, less what the earlier ones foretell of it.
#[derive(Debug, Clone)]
pub struct Whitener(Arc<(Correlation, Vec<f64>)>);

impl Whitener {
    /// Makes `v` white.
    pub fn whiten(&self, v: &[f64]) -> Vec<f64> {
        let (correlation, inverse) = &*self.0;
        correlation.whiten(v.iter().zip(inverse).map(|(x, a)| x * a))
    }

    /// Makes columns white, and appends them to `out`. Every row waits for the one before it: some columns abreast wait
    /// together.
    pub fn whiten_onto<'c>(&self, columns: impl Iterator<Item = &'c [f64]>, out: &mut Columns) {
        let (filter, inverse) = &*self.0;
        let n = inverse.len().max(1);
        let all: Vec<&[f64]> = columns.collect();
        let room = out.further(all.len());
        for (columns, room) in all.chunks(ABREAST).zip(room.chunks_mut(ABREAST * n)) {
            match columns.first_chunk::<ABREAST>().filter(|_| filter.process.parts.len() == 1) {
                Some(columns) => Arch::new().dispatch(WhitenAbreast { filter, inverse, columns, room }),
                None => {
                    let each = columns.iter().zip(room.chunks_exact_mut(n));
                    each.for_each(|(column, room)| room.copy_from_slice(&self.whiten(column)));
                }
            }
        }
    }

    /// The weight of a row in its own whitened value.
    pub fn weight(&self, row: usize) -> f64 {
        let (correlation, inverse) = &*self.0;
        inverse[row] / correlation.new[row]
    }

    /// The transpose of [`Whitener::whiten`].
    pub fn transposed(&self, v: &[f64]) -> Vec<f64> {
        let (correlation, inverse) = &*self.0;
        let mut out = correlation.whiten_transposed(v);
        out.iter_mut().zip(inverse).for_each(|(o, a)| *o *= a);
        out
    }

    /// For every row the squared length of the whitened step that begins there: the rows from there on leave, as a function
    /// of the state m before them, mᵀ A m + 2 bᵀ m + c, and a step begins with m = 0.
    pub fn squared_lengths_of_steps(&self) -> Vec<f64> {
        let (filter, inverse) = &*self.0;
        let parts = filter.process.parts.len();
        let (mut a, mut b, mut c) = (vec![0.0; parts * parts], vec![0.0; parts], 0.0);
        let mut out = vec![0.0; inverse.len()];
        for i in (0..inverse.len()).rev() {
            let here = i * parts..(i + 1) * parts;
            let (left, gain) = (&filter.left[here.clone()], &filter.gain[here]);
            let weight = filter.new[i].powi(-2);
            let value = inverse[i];
            let times_gain = |row: &[f64]| row.iter().zip(gain).map(|(a, k)| a * k).sum::<f64>();
            let ag: Vec<f64> = a.chunks(parts.max(1)).map(times_gain).take(parts).collect();
            let (gag, bg) = (times_gain(&ag), times_gain(&b));
            c += value * value * (weight + gag) + 2.0 * value * bg;
            // The state m⁻ that is expected at the row takes over m⁻ + K (value − Σ m⁻).
            for j in 0..parts {
                for l in 0..parts {
                    let later = a[j * parts + l] - ag[j] - ag[l] + gag;
                    a[j * parts + l] = left[j] * left[l] * (weight + later);
                }
                b[j] = left[j] * (value * (ag[j] - gag - weight) + b[j] - bg);
            }
            out[i] = c;
        }
        out
    }
}
