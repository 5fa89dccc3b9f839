//! Output error of the looped model in the time domain: normal equations by forward sensitivities, exact
//! through the loop and its memory, and their minimisation.
//!
//! The sensitivities of `LANES` parameters run through the rows together, so that their state stays in
//! registers and the first cache.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatRef, Par};
use numerics::{Limits, Normal, minimise, parallel};
use pulp::{Arch, Simd, WithSimd};

use super::looped::{Looped, State, Stepper, Stretch};
use super::operator::Response;
use crate::thresholds::dynamic::linear::sensitivity::{LANES, PIECES};

type Lane = [f64; LANES];

/// Where a parameter enters directly: `targets[target] += sign · sources[source]`, with targets x′, y, z, w
/// and sources x, u, w, ∂w/∂e, each kind after the other.
#[derive(Clone, Copy)]
pub struct Entry {
    pub target: usize,
    pub source: usize,
    pub sign: f64,
}

/// Fits all parameters of `start` to the stretches; stays stable and never becomes worse.
pub fn fit(start: &Looped, stretches: &[Stretch], limits: Limits) -> Looped {
    let normal = |p: &[f64]| normal_equations(&start.with(p), stretches, &[]);
    let cost = |p: &[f64]| cost(&start.with(p), stretches);
    start.with(&minimise(start.parameters(), normal, cost, limits))
}

/// Σ over the stretches of the squared weighted residuals; `None` for an unstable model.
pub fn cost(model: &Looped, stretches: &[Stretch]) -> Option<f64> {
    if !admissible(model) {
        return None;
    }
    let each = parallel::map(stretches, |s| {
        let y = predict(model, s)?;
        let first = s.skip * model.linear.outputs;
        let rest = y[first..].iter().zip(&s.position[first..]);
        Some(s.weight * s.weight * rest.map(|(y, measured)| (y - measured).powi(2)).sum::<f64>())
    });
    each.into_iter().sum()
}

fn admissible(model: &Looped) -> bool {
    // An exponent below −0.95 makes the smallest plays dominate: then w is linear.
    model.linear.stable() && (-0.95..=3.0).contains(&model.operator.exponent)
}

/// Free simulation of a stretch: in steady state, or from the initial state that its first rows give.
pub fn predict(model: &Looped, stretch: &Stretch) -> Option<Vec<f64>> {
    let mut state = start_state(model, stretch)?;
    model.simulate(&stretch.drive, &mut state)
}

fn start_state(model: &Looped, stretch: &Stretch) -> Option<State> {
    let mut state = model.rest();
    if stretch.periodic {
        for _ in 0..model.settling(stretch.rows(model.linear.inputs)) {
            model.simulate(&stretch.drive, &mut state)?;
        }
    } else {
        state.x = super::initial::state(&model.linear, &stretch.drive, &stretch.position, stretch.skip);
    }
    Some(state)
}

/// The trajectory that the sensitivities run along.
struct Trajectory {
    /// Sources x, u, w, ∂w/∂e of every row.
    sources: Vec<f64>,
    /// What the operators gave in every row.
    responses: Vec<Response>,
    y: Vec<f64>,
    /// Rows before the first that is kept.
    lead: usize,
}

/// The normal equations of what a model leaves of the stretches, weighted and, where an autoregression is given, whitened; none
/// of an unstable model.
pub fn normal_equations(model: &Looped, stretches: &[Stretch], whitening: &[f64]) -> Option<Normal> {
    Some(Simulation::of(model, stretches, whitening)?.normal())
}

/// Some stretches, simulated by a model: its cost, and on demand the normal equations, which take several times as long.
pub struct Simulation<'a> {
    model: Looped,
    whitening: &'a [f64],
    stretches: Vec<SimulatedStretch<'a>>,
    /// Σ of the squared residuals, weighted and whitened.
    pub cost: f64,
}

/// A stretch and what a model makes of it.
struct SimulatedStretch<'a> {
    stretch: &'a Stretch,
    path: Trajectory,
    /// The first row that is scored.
    first: usize,
    /// Simulated less measured positions from there on, weighted and whitened; rows × outputs.
    residual: Vec<f64>,
}

impl<'a> Simulation<'a> {
    /// By `model`; none where that is unstable. An autoregression `whitening` may be empty.
    pub fn of(model: &Looped, stretches: &'a [Stretch], whitening: &'a [f64]) -> Option<Simulation<'a>> {
        if !admissible(model) {
            return None;
        }
        let simulated = parallel::map(stretches, |stretch| SimulatedStretch::of(model, stretch, whitening));
        let stretches = simulated.into_iter().collect::<Option<Vec<_>>>()?;
        let cost = stretches.iter().map(|s| numerics::dot(&s.residual, &s.residual)).sum();
        Some(Simulation { model: model.clone(), whitening, stretches, cost })
    }

    /// The normal equations of all parameters, in the order of [`Looped::parameters`].
    pub fn normal(&self) -> Normal {
        let entries = entries(&self.model);
        let mut sum = Normal::zeros(entries.len());
        sum.cost = self.cost;
        for stretch in self.stretches.iter().filter(|s| !s.residual.is_empty()) {
            stretch.add_to(&self.model, &entries, self.whitening, &mut sum);
        }
        sum
    }
}

impl<'a> SimulatedStretch<'a> {
    fn of(model: &Looped, stretch: &'a Stretch, whitening: &[f64]) -> Option<SimulatedStretch<'a>> {
        let p = model.linear.outputs;
        let path = trajectory(model, stretch)?;
        let first = stretch.skip.min(path.y.len() / p - path.lead);
        let measured = &stretch.position[first * p..];
        let predicted = &path.y[(path.lead + first) * p..];
        let mut residual: Vec<f64> =
            predicted.iter().zip(measured).map(|(y, measured)| stretch.weight * (y - measured)).collect();
        whiten(&mut residual, whitening, p);
        Some(SimulatedStretch { stretch, path, first, residual })
    }

    /// Adds its part of the Gram matrix and of the gradient.
    fn add_to(&self, model: &Looped, entries: &[Vec<Entry>], whitening: &[f64], sum: &mut Normal) {
        let (size, kept) = (entries.len(), self.residual.len());
        let lanes: Vec<&[Vec<Entry>]> = entries.chunks(LANES).collect();
        let columns = parallel::map(&lanes, |entries| {
            let mut columns = vec![0.0; kept * entries.len()];
            Arch::new().dispatch(Sensitivities {
                model,
                path: &self.path,
                first: self.path.lead + self.first,
                entries,
                columns: &mut columns,
                kept,
            });
            columns.chunks_exact_mut(kept).for_each(|column| whiten(column, whitening, model.linear.outputs));
            columns
        });
        let jacobian = columns.concat();
        let whole = MatRef::from_column_major_slice(&jacobian, kept, size);
        let piece = kept.div_ceil(PIECES);
        let grams = parallel::indices(0..PIECES, |k| {
            let (from, to) = ((k * piece).min(kept), ((k + 1) * piece).min(kept));
            let part = whole.subrows(from, to - from);
            let mut gram = faer::Mat::<f64>::zeros(size, size);
            triangular::matmul(
                gram.as_mut(),
                BlockStructure::TriangularLower,
                Accum::Replace,
                part.transpose(),
                BlockStructure::Rectangular,
                part,
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
            gram
        });
        let weight = self.stretch.weight;
        for gram in grams {
            sum.gram += faer::Scale(weight * weight) * gram;
        }
        for (g, column) in sum.gradient.iter_mut().zip(jacobian.chunks_exact(kept)) {
            *g += weight * numerics::dot(column, &self.residual);
        }
    }
}

/// What an autoregression does not expect of a column of rows of so many outputs, in place.
fn whiten(column: &mut [f64], coefficients: &[f64], outputs: usize) {
    for at in (0..column.len()).rev() {
        let expected = |(lag, a): (usize, &f64)| {
            at.checked_sub((lag + 1) * outputs).map_or(0.0, |before| a * column[before])
        };
        column[at] -= coefficients.iter().enumerate().map(expected).sum::<f64>();
    }
}

/// Runs the model and keeps what the sensitivities need. A periodic stretch is led in by a quarter of it.
fn trajectory(model: &Looped, stretch: &Stretch) -> Option<Trajectory> {
    let m = model.linear.inputs;
    let rows = stretch.rows(m);
    let lead = if stretch.periodic { rows / 4 } else { 0 };
    let mut state = start_state(model, stretch)?;
    if lead > 0 {
        model.simulate(&stretch.drive[..(rows - lead) * m], &mut state)?;
    }
    let drive = stretch.drive[(rows - lead) * m..].iter().chain(&stretch.drive).copied().collect::<Vec<_>>();
    let mut path = Trajectory { sources: vec![], responses: vec![], y: vec![], lead };
    let mut step = Stepper::new(model);
    for u in drive.chunks_exact(m) {
        path.sources.extend_from_slice(&state.x);
        path.sources.extend_from_slice(u);
        step.run(model, u, &mut state, &mut path.y);
        path.sources.extend_from_slice(&step.w);
        path.sources.extend(step.responses.iter().map(|r| r.by_exponent));
        path.responses.extend_from_slice(&step.responses);
    }
    path.y.iter().all(|y| y.is_finite()).then_some(path)
}

/// For every parameter, in the order of [`Looped::parameters`], where it enters.
pub fn entries(model: &Looped) -> Vec<Vec<Entry>> {
    let lin = &model.linear;
    let (n, m, p, q) = (lin.order(), lin.inputs, lin.outputs, model.loops());
    let mut all = Vec::new();
    for (k, block) in lin.blocks.iter().enumerate() {
        for derivative in block.derivatives() {
            let parts = derivative.iter().enumerate().filter(|(_, d)| **d != 0.0);
            let entry =
                |(i, &sign): (usize, &f64)| Entry { target: 2 * k + i / 2, source: 2 * k + i % 2, sign };
            all.push(parts.map(entry).collect());
        }
    }
    // Matrices by rows: rows are targets from `target` on, columns are sources from `source` on.
    let mut matrix = |rows: usize, columns: usize, target: usize, source: usize| {
        for i in 0..rows {
            for j in 0..columns {
                all.push(vec![Entry { target: target + i, source: source + j, sign: 1.0 }]);
            }
        }
    };
    let (x, u, w) = (0, n, n + m);
    let (next, y, z) = (0, n, n + p);
    matrix(n, m, next, u);
    matrix(p, n, y, x);
    matrix(p, m, y, u);
    if q > 0 {
        matrix(n, q, next, w);
        matrix(p, q, y, w);
        matrix(q, n, z, x);
        matrix(q, m, z, u);
        all.push((0..q).map(|l| Entry { target: n + p + q + l, source: n + m + q + l, sign: 1.0 }).collect());
    }
    all
}

/// Columns of the Jacobian of some parameters, to be worked out in the widest registers that the processor has.
struct Sensitivities<'a> {
    model: &'a Looped,
    path: &'a Trajectory,
    /// The first row that is wanted.
    first: usize,
    /// Where the parameters enter.
    entries: &'a [Vec<Entry>],
    /// The columns, one after another, of `kept` values each.
    columns: &'a mut [f64],
    kept: usize,
}

impl WithSimd for Sensitivities<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Sensitivities { model, path, first, entries, columns, kept } = self;
        let lin = &model.linear;
        let (n, p, q) = (lin.order(), lin.outputs, model.loops());
        let width = n + lin.inputs + 2 * q;
        let cells = model.operator.cells();
        let weights = Stepper::new(model).weights().to_vec();
        let blocks: Vec<[f64; 4]> = lin.blocks.iter().map(|b| b.matrix()).collect();
        let direct: Vec<(usize, Entry)> =
            entries.iter().enumerate().flat_map(|(lane, e)| e.iter().map(move |e| (lane, *e))).collect();
        let mut x = vec![Lane::default(); n];
        let mut plays = vec![Lane::default(); q * cells];
        let mut remembered = vec![Lane::default(); q];
        let mut w = vec![Lane::default(); q];
        let mut targets = vec![Lane::default(); n + p + 2 * q];
        for (row, sources) in path.sources.chunks_exact(width).enumerate() {
            targets.fill(Lane::default());
            for &(lane, entry) in &direct {
                targets[entry.target][lane] += entry.sign * sources[entry.source];
            }
            let (next, rest) = targets.split_at_mut(n);
            let (y, rest) = rest.split_at_mut(p);
            let (z, by_parameter) = rest.split_at_mut(q);
            for l in 0..q {
                let dz = gather(z[l], &model.cz[l * n..(l + 1) * n], &x);
                if cells == 0 {
                    let slope = path.responses[row * q + l].slope;
                    w[l] = std::array::from_fn(|i| slope * dz[i] + by_parameter[l][i]);
                    continue;
                }
                let mut moved = path.responses[row * q + l].moved;
                while moved != 0 {
                    let k = moved.trailing_zeros() as usize;
                    moved &= moved - 1;
                    let play = &mut plays[l * cells + k];
                    for i in 0..LANES {
                        remembered[l][i] += weights[k] * (dz[i] - play[i]);
                    }
                    *play = dz;
                }
                w[l] = std::array::from_fn(|i| remembered[l][i] + by_parameter[l][i]);
            }
            for (i, &own) in y.iter().enumerate().take(p) {
                let mut dy = gather(own, &lin.c[i * n..(i + 1) * n], &x);
                if q > 0 {
                    dy = gather(dy, &model.f[i * q..(i + 1) * q], &w);
                }
                if row >= first {
                    let at = (row - first) * p + i;
                    for (column, dy) in columns.chunks_exact_mut(kept).zip(dy) {
                        column[at] = dy;
                    }
                }
            }
            for (k, a) in blocks.iter().enumerate() {
                let (x0, x1) = (x[2 * k], x[2 * k + 1]);
                for i in 0..LANES {
                    next[2 * k][i] += a[0] * x0[i] + a[1] * x1[i];
                    next[2 * k + 1][i] += a[2] * x0[i] + a[3] * x1[i];
                }
            }
            if q > 0 {
                for (s, e) in model.e.chunks_exact(q).enumerate() {
                    next[s] = gather(next[s], e, &w);
                }
            }
            x.copy_from_slice(next);
        }
    }
}

/// `start + Σ factors · values`, lane by lane.
#[inline(always)]
fn gather(start: Lane, factors: &[f64], values: &[Lane]) -> Lane {
    let mut sum = start;
    for (f, v) in factors.iter().zip(values) {
        for i in 0..LANES {
            sum[i] += f * v[i];
        }
    }
    sum
}

/// Standard error of the operator's exponent at the fit, its residuals taken as white; infinite where the
/// stretches do not determine it.
pub fn exponent_error(model: &Looped, stretches: &[Stretch]) -> f64 {
    use faer::linalg::solvers::Solve;
    let Some(equations) = normal_equations(model, stretches, &[]) else { return f64::INFINITY };
    let size = equations.gradient.len();
    let rows: usize = stretches.iter().map(|s| s.position.len()).sum();
    let scale: Vec<f64> = (0..size).map(|i| 1.0 / equations.gram[(i, i)].sqrt().max(1e-300)).collect();
    // The ridge stands for the coordinates of the states, which nothing determines.
    let scaled = faer::Mat::from_fn(size, size, |i, j| {
        equations.gram[(i.max(j), i.min(j))] * scale[i] * scale[j] + if i == j { 1e-9 } else { 0.0 }
    });
    let unit = faer::Mat::from_fn(size, 1, |i, _| if i + 1 == size { 1.0 } else { 0.0 });
    let Ok(factor) = scaled.llt(faer::Side::Lower) else { return f64::INFINITY };
    let solved = factor.solve(&unit);
    let variance = solved[(size - 1, 0)] * scale[size - 1] * scale[size - 1] * equations.cost;
    (variance / rows.saturating_sub(size).max(1) as f64).sqrt()
}
