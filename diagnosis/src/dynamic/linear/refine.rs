//! Refinement of a linear model in the frequency domain: the output error over all lines and experiments,
//! which for white noise is the maximum likelihood (Pintelon & Schoukens, section 9.11).

use faer::Mat;
use rayon::prelude::*;

use super::modal::Modal;
use crate::dynamic::spectrum::frf::cross;
use crate::dynamic::spectrum::{Complex, Experiments};
use crate::numerics::hermitian::{cholesky, divide};
use crate::numerics::{Limits, Normal, minimise};
use crate::thresholds::dynamic::linear::refine::PIECE;

/// Σ |w (Y − G U)|² over the experiments of a line is Σ |(Ĝ − G) L|² plus what no G can change, with
/// S_uu = L Lᴴ: the experiments enter by Ĝ and L alone.
struct Line {
    point: Complex,
    gain: Vec<Complex>,
    factor: Vec<Complex>,
}

/// Refines `start` on the experiments; stays stable, never becomes worse.
pub fn refine(start: &Modal, data: &Experiments, steps: usize) -> Modal {
    let lines: Vec<Line> = data
        .points()
        .into_iter()
        .enumerate()
        .filter_map(|(line, point)| {
            let (uu, yu) = cross(data, line);
            let factor = cholesky(&uu, data.inputs)?;
            Some(Line { point, gain: divide(&yu, data.outputs, &factor, data.inputs), factor })
        })
        .collect();
    let normal = |parameters: &[f64]| {
        let model = start.with(parameters);
        let pieces: Vec<Normal> =
            lines.par_chunks(PIECE).map(|piece| normal_of(&model, piece, parameters.len())).collect();
        let mut sum = Normal::zeros(parameters.len());
        pieces.iter().for_each(|piece| sum.merge(piece));
        Some(sum)
    };
    let cost = |parameters: &[f64]| {
        let model = start.with(parameters);
        let pieces: Vec<f64> = lines
            .par_chunks(PIECE)
            .map(|piece| {
                piece.iter().map(|l| residual(&model, l).iter().map(|r| r.norm_sqr()).sum::<f64>()).sum()
            })
            .collect();
        model.stable().then(|| pieces.iter().sum())
    };
    let limits = Limits { steps, decrease: 1e-4 };
    start.with(&minimise(start.parameters(), normal, cost, limits))
}

/// (G − Ĝ) L of a line, outputs × inputs.
fn residual(model: &Modal, line: &Line) -> Vec<Complex> {
    let m = model.inputs;
    let error: Vec<Complex> =
        model.response(line.point).iter().zip(&line.gain).map(|(g, measured)| g - measured).collect();
    times_factor(&error, &line.factor, m)
}

/// `rows L` with L lower triangular, m × m.
fn times_factor(rows: &[Complex], l: &[Complex], m: usize) -> Vec<Complex> {
    let mut out = vec![Complex::ZERO; rows.len()];
    for (row, out) in rows.chunks_exact(m).zip(out.chunks_exact_mut(m)) {
        for (j, out) in out.iter_mut().enumerate() {
            *out = (j..m).map(|k| row[k] * l[k * m + j]).sum();
        }
    }
    out
}

fn normal_of(model: &Modal, lines: &[Line], parameters: usize) -> Normal {
    let (n, m, p) = (model.order(), model.inputs, model.outputs);
    let per = 2 * p * m;
    let mut jacobian = Mat::<f64>::zeros(per * lines.len(), parameters);
    let mut rest = vec![0.0; per * lines.len()];
    for (index, line) in lines.iter().enumerate() {
        let first = index * per;
        for (k, r) in residual(model, line).iter().enumerate() {
            rest[first + 2 * k] = r.re;
            rest[first + 2 * k + 1] = r.im;
        }
        // x L: the derivative with respect to C[i, s] is row s of it, in row i.
        let states = times_factor(&model.states_at(line.point), &line.factor, m);
        let outputs = model.outputs_at(line.point);
        let mut put = |i: usize, j: usize, parameter: usize, value: Complex| {
            let row = first + 2 * (i * m + j);
            jacobian[(row, parameter)] = value.re;
            jacobian[(row + 1, parameter)] = value.im;
        };
        for (k, block) in model.blocks.iter().enumerate() {
            for (which, da) in block.derivatives().iter().enumerate() {
                for i in 0..p {
                    let (o0, o1) = (outputs[i * n + 2 * k], outputs[i * n + 2 * k + 1]);
                    for j in 0..m {
                        let (x0, x1) = (states[2 * k * m + j], states[(2 * k + 1) * m + j]);
                        let value = o0 * (da[0] * x0 + da[1] * x1) + o1 * (da[2] * x0 + da[3] * x1);
                        put(i, j, 2 * k + which, value);
                    }
                }
            }
        }
        for s in 0..n {
            for i in 0..p {
                for j in 0..m {
                    for drive in j..m {
                        // B[s, drive] reaches column j of G L through L[drive, j].
                        put(i, j, n + s * m + drive, outputs[i * n + s] * line.factor[drive * m + j]);
                    }
                    put(i, j, n + n * m + i * n + s, states[s * m + j]);
                }
            }
        }
        for i in 0..p {
            for j in 0..m {
                for drive in j..m {
                    put(i, j, n + n * m + p * n + i * m + drive, line.factor[drive * m + j]);
                }
            }
        }
    }
    let mut normal = Normal::zeros(parameters);
    normal.add(&jacobian, &rest);
    normal
}
