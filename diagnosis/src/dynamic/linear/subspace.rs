//! Frequency-domain subspace identification: the start of every linear nominal.
//!
//! Source: T. McKelvey, H. Akçay, L. Ljung, "Subspace-based multivariable system identification from
//! frequency response data", IEEE Trans. Automatic Control 41 (1996) 960–979, algorithm 2 (lines at any
//! frequencies). Y_q = O_q X + Γ_q U_q over all lines and experiments; the range of what Y_q has beside U_q
//! is that of the observability matrix O_q. Its Gram matrices consist of only 2q − 1 different blocks, so
//! they are summed directly and the tall factorisation is not needed.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::modal::{Block, Modal};
use crate::dynamic::spectrum::frf::Line;
use crate::dynamic::spectrum::{Complex, Experiments};
use crate::thresholds::dynamic::linear::modal::STABLE;
use crate::thresholds::dynamic::linear::subspace::RIDGE;

/// The observability range, of which models of any order are read.
pub struct Subspace {
    directions: Mat<f64>,
    points: Vec<Complex>,
    gain: Vec<Complex>,
    weight: Vec<f64>,
    inputs: usize,
    outputs: usize,
    step_s: f64,
}

/// Finds the observability range with `blocks` block rows; `None` where the drives do not determine a
/// frequency response on any line.
pub fn subspace(data: &Experiments, blocks: usize) -> Option<Subspace> {
    let (m, p) = (data.inputs, data.outputs);
    let mut points = Vec::new();
    let mut gain = Vec::new();
    let mut weight = Vec::new();
    // Sums over lines of z^k S for lags k = −(q−1) … q−1; real parts only (conjugate lines complete them).
    let lags = 2 * blocks - 1;
    let mut uu = vec![vec![0.0; m * m]; lags];
    let mut yu = vec![vec![0.0; p * m]; lags];
    let mut yy = vec![vec![0.0; p * p]; lags];
    for (line, &z) in data.points().iter().enumerate() {
        let Some(Line { uu: s_uu, yu: s_yu, gain: g, .. }) = Line::of(data, line) else { continue };
        // G S_uu Gᴴ: what the drives explain of the positions; noise is left out.
        let s_yy = times_adjoint(&s_yu, &g, p, m);
        let mut power = z.powi(1 - blocks as i32);
        for lag in 0..lags {
            for (sum, s) in [(&mut uu[lag], &s_uu), (&mut yu[lag], &s_yu), (&mut yy[lag], &s_yy)] {
                for (sum, s) in sum.iter_mut().zip(s) {
                    *sum += (power * s).re;
                }
            }
            power *= z;
        }
        points.push(z);
        weight.push((0..m).map(|j| s_uu[j * m + j].re).sum::<f64>() / m as f64);
        gain.extend(g);
    }
    if points.len() < 2 {
        return None;
    }
    let block_matrix = |sums: &[Vec<f64>], rows: usize, columns: usize| {
        Mat::from_fn(blocks * rows, blocks * columns, |i, j| {
            let lag = (i / rows + blocks - 1) - j / columns;
            sums[lag][(i % rows) * columns + j % columns]
        })
    };
    let mut drives = block_matrix(&uu, m, m);
    let ridge = RIDGE * (0..drives.nrows()).map(|i| drives[(i, i)]).sum::<f64>() / drives.nrows() as f64;
    for i in 0..drives.nrows() {
        drives[(i, i)] += ridge;
    }
    let mixed = block_matrix(&yu, p, m);
    let positions = block_matrix(&yy, p, p);
    let factor = drives.llt(Side::Lower).ok()?;
    let solved = factor.solve(mixed.transpose());
    let left = positions - &mixed * &solved;
    let symmetric = Mat::from_fn(left.nrows(), left.nrows(), |i, j| 0.5 * (left[(i, j)] + left[(j, i)]));
    let eigen = symmetric.self_adjoint_eigen(Side::Lower).ok()?;
    let size = symmetric.nrows();
    let vectors = eigen.U();
    let directions = Mat::from_fn(size, size, |i, j| vectors[(i, size - 1 - j)]);
    Some(Subspace { directions, points, gain, weight, inputs: m, outputs: p, step_s: data.step_s })
}

/// `a gᴴ` of two outputs × inputs matrices.
fn times_adjoint(a: &[Complex], g: &[Complex], p: usize, m: usize) -> Vec<Complex> {
    let mut out = vec![Complex::ZERO; p * p];
    for i in 0..p {
        for k in 0..p {
            out[i * p + k] = (0..m).map(|j| a[i * m + j] * g[k * m + j].conj()).sum();
        }
    }
    out
}

impl Subspace {
    /// Largest order that its block rows carry.
    pub fn most(&self) -> usize {
        self.directions.nrows().saturating_sub(self.outputs) / 2 * 2
    }

    /// The model with `order` states (even), stable; B and D by least squares on the frequency response.
    pub fn model(&self, order: usize) -> Option<Modal> {
        let order = order.min(self.most()) / 2 * 2;
        let p = self.outputs;
        let rows = self.directions.nrows();
        if order == 0 {
            return None;
        }
        let range = self.directions.subcols(0, order);
        let upper = range.subrows(0, rows - p);
        let lower = range.subrows(p, rows - p);
        let gram = upper.transpose() * upper;
        let a = gram.llt(Side::Lower).ok()?.solve(upper.transpose() * lower);
        let (blocks, basis) = to_blocks(&a)?;
        let c = range.subrows(0, p) * &basis;
        let c = (0..p * order).map(|i| c[(i / order, i % order)]).collect();
        let (m, step_s) = (self.inputs, self.step_s);
        let mut model =
            Modal { inputs: m, outputs: p, step_s, blocks, b: vec![0.0; order * m], c, d: vec![0.0; p * m] };
        self.fill_inputs(&mut model)?;
        Some(model)
    }

    /// B and D by weighted least squares: G is linear in them once A and C are known.
    fn fill_inputs(&self, model: &mut Modal) -> Option<()> {
        let (n, m, p) = (model.order(), self.inputs, self.outputs);
        let unknowns = n + p;
        let mut gram = Mat::<f64>::zeros(unknowns, unknowns);
        let mut right = Mat::<f64>::zeros(unknowns, m);
        let chunk = 256;
        for start in (0..self.points.len()).step_by(chunk) {
            let end = (start + chunk).min(self.points.len());
            let mut design = Mat::<f64>::zeros(2 * p * (end - start), unknowns);
            let mut target = Mat::<f64>::zeros(2 * p * (end - start), m);
            for line in start..end {
                let root = self.weight[line].sqrt();
                let out = model.outputs_at(self.points[line]);
                for i in 0..p {
                    let row = 2 * (p * (line - start) + i);
                    for s in 0..n {
                        design[(row, s)] = root * out[i * n + s].re;
                        design[(row + 1, s)] = root * out[i * n + s].im;
                    }
                    design[(row, n + i)] = root;
                    for j in 0..m {
                        let g = self.gain[(line * p + i) * m + j];
                        target[(row, j)] = root * g.re;
                        target[(row + 1, j)] = root * g.im;
                    }
                }
            }
            gram += design.transpose() * &design;
            right += design.transpose() * &target;
        }
        // Scaled to a unit diagonal: states differ in size by the damping of their modes.
        let scale: Vec<f64> =
            (0..unknowns).map(|i| 1.0 / gram[(i, i)].sqrt().max(f64::MIN_POSITIVE)).collect();
        let scaled = Mat::from_fn(unknowns, unknowns, |i, j| {
            gram[(i, j)] * scale[i] * scale[j] + if i == j { 1e-10 } else { 0.0 }
        });
        let scaled_right = Mat::from_fn(unknowns, m, |i, j| right[(i, j)] * scale[i]);
        let solved = scaled.llt(Side::Lower).ok()?.solve(&scaled_right);
        for j in 0..m {
            for s in 0..n {
                model.b[s * m + j] = solved[(s, j)] * scale[s];
            }
            for i in 0..p {
                model.d[i * m + j] = solved[(n + i, j)] * scale[n + i];
            }
        }
        Some(())
    }
}

/// A = T blockdiag T⁻¹ with real 2 × 2 blocks; poles outside the unit circle are reflected into it.
pub(super) fn to_blocks(a: &Mat<f64>) -> Option<(Vec<Block>, Mat<f64>)> {
    let n = a.nrows();
    let eigen = a.eigen().ok()?;
    let values = eigen.S().column_vector();
    let vectors = eigen.U();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| values[i].arg().abs().total_cmp(&values[j].arg().abs()).then(i.cmp(&j)));
    let mut basis = Mat::<f64>::zeros(n, n);
    let mut blocks = Vec::new();
    let mut column = 0;
    let mut reals: Vec<usize> = Vec::new();
    for &i in &order {
        let value = inside(values[i]);
        if value.im > 0.0 {
            // A v = λ v with v = r + i s: A [r s] = [r s] [[re, im], [−im, re]].
            for row in 0..n {
                basis[(row, column)] = vectors[(row, i)].re;
                basis[(row, column + 1)] = vectors[(row, i)].im;
            }
            blocks.push(Block { pair: true, parameters: [value.re, value.im] });
            column += 2;
        } else if value.im == 0.0 {
            reals.push(i);
        }
    }
    for pair in reals.chunks_exact(2) {
        for (k, &i) in pair.iter().enumerate() {
            for row in 0..n {
                basis[(row, column + k)] = vectors[(row, i)].re;
            }
        }
        blocks.push(Block { pair: false, parameters: [pair[0], pair[1]].map(|i| inside(values[i]).re) });
        column += 2;
    }
    (column == n).then_some((blocks, basis))
}

fn inside(value: Complex) -> Complex {
    let radius = value.norm();
    if radius < STABLE { value } else { value / (radius * radius) * 0.999 }
}
