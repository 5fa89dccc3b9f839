//! Refinement of a linear model in the frequency domain: the output error over all lines and experiments,
//! which for white noise is the maximum likelihood (Pintelon & Schoukens, section 9.11).

use faer::Mat;
use numerics::{Limits, Normal, minimise, parallel};

use super::looped::Looped;
use super::modal::Modal;
use super::sensitivity::{Entry, entries};
use crate::dynamic::spectrum::frf::Line;
use crate::dynamic::spectrum::{Complex, Experiments};
use crate::thresholds::dynamic::linear::refine::PIECE;

/// A line with its point z. Σ |w (Y − G U)|² over the experiments of it is Σ |(Ĝ − G) L|² plus what no G can change, with
/// S_uu = L Lᴴ: the experiments enter by Ĝ and L alone.
type Point = (Complex, Line);

/// Refines `start` on the experiments; stays stable, never becomes worse.
pub fn refine(start: &Modal, data: &Experiments, steps: usize) -> Modal {
    let points = data.points().into_iter().enumerate();
    let lines: Vec<Point> = points.filter_map(|(k, point)| Some((point, Line::of(data, k)?))).collect();
    let entries = entries(&Looped::plain(start.clone()));
    let pieces: Vec<&[Point]> = lines.chunks(PIECE).collect();
    let normal = |parameters: &[f64]| {
        let model = start.with(parameters);
        let pieces = parallel::map(&pieces, |piece| normal_of(&model, &entries, piece));
        let mut sum = Normal::zeros(parameters.len());
        pieces.iter().for_each(|piece| sum.merge(piece));
        Some(sum)
    };
    let cost = |parameters: &[f64]| {
        let model = start.with(parameters);
        let squares = parallel::map(&pieces, |piece| {
            piece.iter().map(|l| residual(&model, l).iter().map(|r| r.norm_sqr()).sum::<f64>()).sum::<f64>()
        });
        model.stable().then(|| squares.iter().sum())
    };
    let limits = Limits { steps, decrease: 1e-4 };
    start.with(&minimise(start.parameters(), normal, cost, limits))
}

/// (G − Ĝ) L of a line, outputs × inputs.
fn residual(model: &Modal, (point, line): &Point) -> Vec<Complex> {
    let m = model.inputs;
    let error: Vec<Complex> =
        model.response(*point).iter().zip(&line.gain).map(|(g, measured)| g - measured).collect();
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

fn normal_of(model: &Modal, entries: &[Vec<Entry>], lines: &[Point]) -> Normal {
    let (n, m, p) = (model.order(), model.inputs, model.outputs);
    let per = 2 * p * m;
    let mut jacobian = Mat::<f64>::zeros(per * lines.len(), entries.len());
    let mut rest = vec![0.0; per * lines.len()];
    for (index, at) in lines.iter().enumerate() {
        let (first, (point, line)) = (index * per, at);
        for (k, r) in residual(model, at).iter().enumerate() {
            rest[first + 2 * k] = r.re;
            rest[first + 2 * k + 1] = r.im;
        }
        // What enters: x L and u L, the latter being L; and what it does to the positions, by x′ and at once.
        let states = times_factor(&model.states_at(*point), &line.factor, m);
        let sources = [states, line.factor.clone()].concat();
        let outputs = model.outputs_at(*point);
        let reaches = |target: usize, i: usize| match target {
            state if state < n => outputs[i * n + state],
            output => Complex::new(f64::from(u8::from(output - n == i)), 0.0),
        };
        for (parameter, entry) in entries.iter().enumerate().flat_map(|(k, e)| e.iter().map(move |e| (k, e)))
        {
            for i in 0..p {
                let reach = reaches(entry.target, i) * entry.sign;
                for j in 0..m {
                    let (row, value) = (first + 2 * (i * m + j), reach * sources[entry.source * m + j]);
                    jacobian[(row, parameter)] += value.re;
                    jacobian[(row + 1, parameter)] += value.im;
                }
            }
        }
    }
    let mut normal = Normal::zeros(entries.len());
    normal.add(&jacobian, &rest);
    normal
}
