//! The frequency response: the best linear approximation of a periodic recording, Welch's estimate of any
//! other.

use numerics::hermitian::{cholesky, divide};

use super::{Complex, Experiments};
use crate::intervals::widening;
use crate::thresholds::NORMAL_95;

/// A frequency response on the lines of its experiments.
#[derive(Debug, Clone)]
pub struct Response {
    /// Frequency of every line, Hz.
    pub frequency_hz: Vec<f64>,
    /// G by line, `outputs × inputs` by rows; position unit per drive unit.
    pub gain: Vec<Complex>,
    /// Power of the position by line and output, mean over experiments; position unit².
    pub power: Vec<f64>,
    /// Power of what G leaves by line and output, corrected for the degrees of freedom; `None` where there
    /// are no more experiments than inputs.
    pub residual: Option<Vec<f64>>,
    /// Half the 95 % interval of Σ|G|² over outputs and inputs by line; `None` like `residual`.
    pub half_interval: Option<Vec<f64>>,
}

impl Response {
    /// Σ|G|² over outputs and inputs by line.
    pub fn size(&self) -> Vec<f64> {
        let per = self.gain.len() / self.frequency_hz.len().max(1);
        self.gain.chunks_exact(per.max(1)).map(|g| g.iter().map(|g| g.norm_sqr()).sum()).collect()
    }
}

/// G = S_yu S_uu⁻¹ over all experiments, weighted by their `weight` squared (Pintelon & Schoukens, Eq. 2-54
/// and 4-24). Lines on which the drives do not span all inputs get a zero response.
pub fn response(data: &Experiments) -> Response {
    let (m, p, count) = (data.inputs, data.outputs, data.each.len());
    let mut gain = Vec::with_capacity(data.lines.len() * p * m);
    let (mut power, mut residual, mut half_interval) = (Vec::new(), Vec::new(), Vec::new());
    let freedom = count.saturating_sub(m) as f64;
    // Real and imaginary part count each.
    let quantile = NORMAL_95 * widening(2.0 * freedom);
    for line in 0..data.lines.len() {
        let found = Line::of(data, line);
        let g = found.as_ref().map_or_else(|| vec![Complex::ZERO; p * m], |line| line.gain.clone());
        let mut variance = 0.0;
        for i in 0..p {
            let (mut all, mut left, mut weights) = (0.0, 0.0, 0.0);
            for e in &data.each {
                let weight = e.weight * e.weight;
                let y = e.position[line * p + i];
                let model: Complex = (0..m).map(|j| g[i * m + j] * e.drive[line * m + j]).sum();
                all += weight * y.norm_sqr();
                left += weight * (y - model).norm_sqr();
                weights += weight;
            }
            power.push(all / weights.max(f64::MIN_POSITIVE));
            residual.push(left / weights.max(f64::MIN_POSITIVE) * count as f64 / freedom.max(1.0));
            let own = found.as_ref().map_or(0.0, |line| line.variance_of_size(i, m));
            variance += own * left / freedom.max(1.0);
        }
        half_interval.push(quantile * variance.sqrt());
        gain.extend(g);
    }
    let known = freedom > 0.0;
    Response {
        frequency_hz: data.frequencies(),
        gain,
        power,
        residual: known.then_some(residual),
        half_interval: known.then_some(half_interval),
    }
}

/// What the experiments say on one line: weighted sums over them, and what follows.
pub struct Line {
    /// S_uu, inputs × inputs.
    pub uu: Vec<Complex>,
    /// S_yu, outputs × inputs.
    pub yu: Vec<Complex>,
    /// L of S_uu = L Lᴴ.
    pub factor: Vec<Complex>,
    /// G = S_yu S_uu⁻¹.
    pub gain: Vec<Complex>,
}

impl Line {
    /// None where the drives do not span all inputs.
    pub fn of(data: &Experiments, line: usize) -> Option<Line> {
        let (m, p) = (data.inputs, data.outputs);
        let mut uu = vec![Complex::ZERO; m * m];
        let mut yu = vec![Complex::ZERO; p * m];
        for e in &data.each {
            let weight = e.weight * e.weight;
            let u = &e.drive[line * m..(line + 1) * m];
            let y = &e.position[line * p..(line + 1) * p];
            outer(&mut uu, u, u, weight);
            outer(&mut yu, y, u, weight);
        }
        let factor = cholesky(&uu, m)?;
        let gain = divide(&yu, p, &factor, m);
        Some(Line { uu, yu, factor, gain })
    }

    /// Variance of Σ|G|² over the `inputs` of an output, for noise of variance 1: G is off by ε with E(εᴴε) = S_uu⁻¹, so
    /// that 2 Re(G εᴴ) has the variance 2 G S_uu⁻¹ Gᴴ.
    fn variance_of_size(&self, output: usize, inputs: usize) -> f64 {
        let gain = &self.gain[output * inputs..(output + 1) * inputs];
        let over = divide(gain, 1, &self.factor, inputs);
        2.0 * over.iter().zip(gain).map(|(x, g)| (x * g.conj()).re).sum::<f64>()
    }
}

/// `sum += weight a bᴴ`.
fn outer(sum: &mut [Complex], a: &[Complex], b: &[Complex], weight: f64) {
    for (row, a) in sum.chunks_exact_mut(b.len()).zip(a) {
        for (s, b) in row.iter_mut().zip(b) {
            *s += weight * a * b.conj();
        }
    }
}
