//! Normal equations of a free-run simulation: the simulation runs once with its sensitivities, and only the
//! inner products of residual and sensitivities are kept, for every run and kind of row apart.

use numerics::{Symmetric, parallel};
use physics::number::{Dual, Number};

use super::data::{Data, FOLDS, Folds, over};
use super::model::Model;
use super::simulate::{Theta, Unstable, simulate};
use crate::thresholds::dynamic::gram::STATE;

/// Inner products of the sensitivities (first the run's initial state, then the free parameters) and, in the last place, of the residual.
pub struct Grams {
    /// One matrix per run and kind of row.
    pub products: Vec<[Symmetric; FOLDS]>,
    /// Rows that went into it, per kind.
    pub rows: [usize; FOLDS],
    /// Numbers of a run's initial state.
    pub states: usize,
}

/// What one run adds to them: products and rows of every kind.
type OfRun = ([Symmetric; FOLDS], [usize; FOLDS]);

/// Simulates a second-order plant and collects its normal equations through several filters, as
/// [`Simulated::normals`](super::estimate::Simulated::normals).
///
/// # Errors
/// [`Unstable`] where the simulation leaves every bound.
pub fn grams<const F: usize>(
    model: &Model,
    states: &[[f64; 2]],
    data: &Data,
    filters: [&[f64]; F],
) -> Result<[Grams; F], Unstable> {
    if model.free() + STATE <= 8 {
        collect::<8, F>(model, states, data, filters)
    } else if model.free() + STATE <= 12 {
        collect::<12, F>(model, states, data, filters)
    } else {
        collect::<16, F>(model, states, data, filters)
    }
}

/// The model's parameters as dual numbers: direction 2 + i is the i-th packed parameter.
fn seeded<const N: usize>(model: &Model) -> Theta<Dual<N>> {
    let mut next = STATE;
    let mut variable = |value: f64, free: bool, shape: bool| {
        if !free || next >= N {
            return Dual::from_f64(value);
        }
        let x = Dual::variable(value, next);
        next += 1;
        // A shape is estimated by its logarithm.
        if shape { x.chain(value, value) } else { x }
    };
    let nominal = [0, 1, 2].map(|k| variable(model.nominal[k], model.nominal_free[k], false));
    let terms = model
        .terms
        .iter()
        .map(|term| {
            let kinds = term.effect.parameters.iter().map(|p| p.shape);
            let values = term.parameters.iter().zip(&term.free);
            values.zip(kinds).map(|((v, free), shape)| variable(*v, *free, shape)).collect()
        })
        .collect();
    Theta { nominal, terms }
}

fn collect<const N: usize, const F: usize>(
    model: &Model,
    states: &[[f64; 2]],
    data: &Data,
    filters: [&[f64]; F],
) -> Result<[Grams; F], Unstable> {
    let theta = seeded::<N>(model);
    through(STATE, STATE + model.free(), data, filters, |number, visit| {
        let start = [0, 1].map(|k| Dual::variable(states[number][k], k));
        simulate(model, &theta, &data.course(number, model), start, visit)
    })
}

/// The normal equations through several filters of what `run` simulates: a run by number, which gives its visitor every
/// row's position with `lanes` sensitivities, those by the `states` numbers of the initial state first.
///
/// # Errors
/// [`Unstable`].
pub fn through<const N: usize, const F: usize>(
    states: usize,
    lanes: usize,
    data: &Data,
    filters: [&[f64]; F],
    simulate: impl Fn(usize, &mut dyn FnMut(usize, Dual<N>)) -> Result<(), Unstable> + Sync,
) -> Result<[Grams; F], Unstable> {
    let kept = filters.iter().map(|f| f.len()).max().unwrap_or(0);
    let of_run = |number: usize| -> Result<[OfRun; F], Unstable> {
        let run = &data.runs[number];
        let mut sums = filters.map(|_| ([(); FOLDS].map(|()| Sums::<N>::new()), [0; FOLDS]));
        // The last few residuals, the newest at `newest`.
        let mut past = vec![(0.0, [0.0; N]); kept.max(1)];
        let mut newest = 0;
        simulate(number, &mut |k, y: Dual<N>| {
            let row = run.start + k;
            let fold = data.fold[row] as usize;
            let now = (data.position[row] - y.value, y.slopes);
            for (filter, (sums, rows)) in filters.iter().zip(&mut sums) {
                if k < filter.len() {
                    continue;
                }
                let mut white = now;
                for (j, c) in filter.iter().enumerate() {
                    let (r, s) = &past[(newest + kept - j) % kept];
                    white.0 -= c * r;
                    for (a, b) in white.1.iter_mut().zip(s) {
                        *a -= c * b;
                    }
                }
                sums[fold].add(white.0, &white.1);
                rows[fold] += 1;
            }
            if kept > 0 {
                newest = (newest + 1) % kept;
                past[newest] = now;
            }
        })?;
        Ok(sums.map(|(sums, rows)| (sums.map(|s| s.symmetric(lanes)), rows)))
    };
    let runs = parallel::indices(0..data.runs.len(), of_run);
    let mut grams =
        filters.map(|_| Grams { products: Vec::with_capacity(runs.len()), rows: [0; FOLDS], states });
    for run in runs {
        for (grams, (products, rows)) in grams.iter_mut().zip(run?) {
            grams.products.push(products);
            grams.rows.iter_mut().zip(rows).for_each(|(sum, rows)| *sum += rows);
        }
    }
    Ok(grams)
}

/// Running sums of one kind of row.
struct Sums<const N: usize> {
    square: f64,
    gradient: [f64; N],
    matrix: [[f64; N]; N],
}

impl<const N: usize> Sums<N> {
    fn new() -> Sums<N> {
        Sums { square: 0.0, gradient: [0.0; N], matrix: [[0.0; N]; N] }
    }

    #[inline]
    fn add(&mut self, residual: f64, slopes: &[f64; N]) {
        self.square += residual * residual;
        for i in 0..N {
            self.gradient[i] += residual * slopes[i];
            for j in 0..N {
                self.matrix[i][j] += slopes[i] * slopes[j];
            }
        }
    }

    fn symmetric(&self, lanes: usize) -> Symmetric {
        let mut out = Symmetric::zero(lanes + 1);
        for i in 0..lanes {
            for j in 0..lanes {
                *out.at_mut(i, j) = self.matrix[i][j];
            }
            *out.at_mut(i, lanes) = self.gradient[i];
            *out.at_mut(lanes, i) = self.gradient[i];
        }
        *out.at_mut(lanes, lanes) = self.square;
        out
    }
}

impl Grams {
    /// Sum of squared residuals of the wanted kinds of rows.
    pub fn cost(&self, folds: Folds) -> f64 {
        let last = |m: &Symmetric| m.at(m.size - 1, m.size - 1);
        self.products.iter().map(|run| over(folds, &run.each_ref().map(last))).sum()
    }

    /// Number of rows of the wanted kinds.
    pub fn rows(&self, folds: Folds) -> usize {
        over(folds, &self.rows)
    }

    /// A run's matrix, summed over the wanted kinds of rows.
    pub fn of_run(&self, run: usize, folds: Folds) -> Symmetric {
        let mut sum = Symmetric::zero(self.products[run][0].size);
        for f in (0..FOLDS).filter(|f| folds[*f]) {
            for (a, b) in sum.entries.iter_mut().zip(&self.products[run][f].entries) {
                *a += b;
            }
        }
        sum
    }

    /// The normal equations of the parameters alone, the initial states of all runs eliminated (Schur
    /// complement): sensitivities first, the residual last. `lambda` is the damping of Marquardt, `scales` that of each
    /// parameter beside it.
    pub fn reduced(&self, folds: Folds, lambda: f64, scales: &[f64]) -> Symmetric {
        let states = self.states;
        let size = self.products[0][0].size - states;
        let mut sum = Symmetric::zero(size);
        for run in 0..self.products.len() {
            let whole = self.of_run(run, folds);
            let block = self.state_block(&whole, lambda).factor();
            for j in 0..size {
                let column: Vec<f64> = (0..states).map(|k| whole.at(k, states + j)).collect();
                let solved = block.solve(&column);
                for i in 0..size {
                    let through: f64 =
                        solved.iter().enumerate().map(|(k, s)| whole.at(states + i, k) * s).sum();
                    *sum.at_mut(i, j) += whole.at(states + i, states + j) - through;
                }
            }
        }
        scales.iter().enumerate().for_each(|(i, scale)| *sum.at_mut(i, i) += lambda * scale);
        sum
    }

    /// Squared sensitivity to each parameter.
    pub fn scales(&self, folds: Folds) -> Vec<f64> {
        let mut sums = vec![0.0; self.products[0][0].size - self.states - 1];
        for run in 0..self.products.len() {
            let whole = self.of_run(run, folds);
            sums.iter_mut().zip(self.states..).for_each(|(sum, i)| *sum += whole.at(i, i));
        }
        sums
    }

    /// A run's initial state that goes with a step of the parameters, then that step.
    pub fn with_state(&self, whole: &Symmetric, step: &[f64], lambda: f64) -> Vec<f64> {
        let last = whole.size - 1;
        let moved = |i: usize| -> f64 {
            step.iter().enumerate().map(|(j, s)| whole.at(i, self.states + j) * s).sum()
        };
        let right: Vec<f64> = (0..self.states).map(|i| whole.at(i, last) - moved(i)).collect();
        let state = self.state_block(whole, lambda).factor().solve(&right);
        state.iter().chain(step).copied().collect()
    }

    /// By how much every run's initial state moves where the parameters are held, and the decrease of the cost that the
    /// linearised model promises.
    pub fn step_of_states(&self, folds: Folds) -> (Vec<Vec<f64>>, f64) {
        let mut promised = 0.0;
        let of_run = |run: usize| {
            let whole = self.of_run(run, folds);
            let last = whole.size - 1;
            let mut moves = self.with_state(&whole, &vec![0.0; last - self.states], 0.0);
            moves.truncate(self.states);
            promised += moves.iter().enumerate().map(|(i, by)| by * whole.at(i, last)).sum::<f64>();
            moves
        };
        ((0..self.products.len()).map(of_run).collect(), promised)
    }

    /// The step of Levenberg and Marquardt: of the parameters, of every run's initial state, and the
    /// decrease of the cost that the linearised model promises.
    pub fn step(&self, folds: Folds, lambda: f64, scales: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>, f64) {
        let reduced = self.reduced(folds, lambda, scales);
        let size = reduced.size - 1;
        let right: Vec<f64> = (0..size).map(|i| reduced.at(i, size)).collect();
        let step = reduced.part(0..size).factor().solve(&right);
        let mut promised = 0.0;
        let states = (0..self.products.len())
            .map(|run| {
                let whole = self.of_run(run, folds);
                let last = whole.size - 1;
                let full = self.with_state(&whole, &step, lambda);
                for i in 0..full.len() {
                    promised += 2.0 * full[i] * whole.at(i, last);
                    promised -= (0..full.len()).map(|j| full[i] * whole.at(i, j) * full[j]).sum::<f64>();
                }
                full[..self.states].to_vec()
            })
            .collect();
        (step, states, promised)
    }

    fn state_block(&self, whole: &Symmetric, lambda: f64) -> Symmetric {
        let mut block = whole.part(0..self.states);
        (0..self.states).for_each(|i| *block.at_mut(i, i) *= 1.0 + lambda);
        block
    }
}
