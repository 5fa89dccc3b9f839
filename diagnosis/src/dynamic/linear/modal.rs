//! A multivariable linear state space in modal form: A of 2 × 2 blocks, so that a sample costs 2 n products
//! and every pole is a parameter.

use crate::dynamic::spectrum::Complex;
use crate::thresholds::dynamic::linear::modal::STABLE;

/// One 2 × 2 block of A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Whether it is a pair of complex poles `re ± i·im`, `[[re, im], [−im, re]]`; otherwise two real ones, `diag(first,
    /// second)`.
    pub pair: bool,
    /// `re` and `im`, or `first` and `second`.
    pub parameters: [f64; 2],
}

impl Block {
    /// The block by rows.
    pub fn matrix(self) -> [f64; 4] {
        let [a, b] = self.parameters;
        if self.pair { [a, b, -b, a] } else { [a, 0.0, 0.0, b] }
    }

    /// Derivatives of the block, by rows, with respect to its two parameters.
    pub fn derivatives(self) -> [[f64; 4]; 2] {
        match self.pair {
            true => [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, -1.0, 0.0]],
            false => [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
        }
    }

    /// Largest modulus of its poles.
    pub fn radius(self) -> f64 {
        let [a, b] = self.parameters;
        if self.pair { a.hypot(b) } else { a.abs().max(b.abs()) }
    }

    /// (zI − A_k)⁻¹ by rows.
    pub fn resolvent(self, z: Complex) -> [Complex; 4] {
        let [a, b, c, d] = self.matrix();
        let inverse = ((z - a) * (z - d) - b * c).inv();
        [(z - d) * inverse, b * inverse, c * inverse, (z - a) * inverse]
    }
}

/// x′ = A x + B u, y = C x + D u in discrete time; matrices by rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Modal {
    /// Number of drives.
    pub inputs: usize,
    /// Number of positions.
    pub outputs: usize,
    /// Time from one sample to the next, s.
    pub step_s: f64,
    /// A, block by block.
    pub blocks: Vec<Block>,
    /// B, states × inputs.
    pub b: Vec<f64>,
    /// C, outputs × states.
    pub c: Vec<f64>,
    /// D, outputs × inputs.
    pub d: Vec<f64>,
}

impl Modal {
    /// Number of states.
    pub fn order(&self) -> usize {
        2 * self.blocks.len()
    }

    /// Whether all poles lie inside the unit circle.
    pub fn stable(&self) -> bool {
        self.blocks.iter().all(|b| b.radius() < STABLE)
    }

    /// Parameters: two per block, then B, C and D by rows.
    pub fn parameters(&self) -> Vec<f64> {
        let blocks = self.blocks.iter().flat_map(|b| b.parameters);
        blocks.chain(self.b.iter().chain(&self.c).chain(&self.d).copied()).collect()
    }

    /// The same structure with other parameters (as many as [`Modal::parameters`] gives).
    pub fn with(&self, parameters: &[f64]) -> Modal {
        let (n, nb, nc) = (self.order(), self.b.len(), self.c.len());
        let each = self.blocks.iter().zip(parameters.chunks_exact(2));
        let blocks = each.map(|(b, p)| Block { parameters: [p[0], p[1]], ..*b }).collect();
        Modal {
            blocks,
            b: parameters[n..n + nb].to_vec(),
            c: parameters[n + nb..n + nb + nc].to_vec(),
            d: parameters[n + nb + nc..].to_vec(),
            ..*self
        }
    }

    /// (zI − A)⁻¹ B, states × inputs.
    pub fn states_at(&self, z: Complex) -> Vec<Complex> {
        let m = self.inputs;
        let mut out = vec![Complex::ZERO; self.order() * m];
        for (k, block) in self.blocks.iter().enumerate() {
            let r = block.resolvent(z);
            for j in 0..m {
                let (b0, b1) = (self.b[2 * k * m + j], self.b[(2 * k + 1) * m + j]);
                out[2 * k * m + j] = r[0] * b0 + r[1] * b1;
                out[(2 * k + 1) * m + j] = r[2] * b0 + r[3] * b1;
            }
        }
        out
    }

    /// C (zI − A)⁻¹, outputs × states.
    pub fn outputs_at(&self, z: Complex) -> Vec<Complex> {
        let (n, p) = (self.order(), self.outputs);
        let mut out = vec![Complex::ZERO; p * n];
        for (k, block) in self.blocks.iter().enumerate() {
            let r = block.resolvent(z);
            for i in 0..p {
                let (c0, c1) = (self.c[i * n + 2 * k], self.c[i * n + 2 * k + 1]);
                out[i * n + 2 * k] = c0 * r[0] + c1 * r[2];
                out[i * n + 2 * k + 1] = c0 * r[1] + c1 * r[3];
            }
        }
        out
    }

    /// The frequency response at z = e^(iωT), outputs × inputs.
    pub fn response(&self, z: Complex) -> Vec<Complex> {
        let (n, m, p) = (self.order(), self.inputs, self.outputs);
        let states = self.states_at(z);
        let mut out: Vec<Complex> = self.d.iter().map(|&d| Complex::new(d, 0.0)).collect();
        for i in 0..p {
            for s in 0..n {
                for j in 0..m {
                    out[i * m + j] += self.c[i * n + s] * states[s * m + j];
                }
            }
        }
        out
    }

    /// `next = A x + B u`.
    pub fn advance(&self, x: &[f64], u: &[f64], next: &mut [f64]) {
        let m = self.inputs;
        for (k, block) in self.blocks.iter().enumerate() {
            let [a, b, c, d] = block.matrix();
            let (x0, x1) = (x[2 * k], x[2 * k + 1]);
            next[2 * k] = a * x0 + b * x1;
            next[2 * k + 1] = c * x0 + d * x1;
        }
        for (s, next) in next.iter_mut().enumerate() {
            for (b, u) in self.b[s * m..(s + 1) * m].iter().zip(u) {
                *next += b * u;
            }
        }
    }

    /// `rows A` of some rows of as many numbers as there are states, in place.
    pub fn times_a(&self, rows: &mut [f64]) {
        for row in rows.chunks_exact_mut(self.order()) {
            for (c, block) in row.chunks_exact_mut(2).zip(&self.blocks) {
                let a = block.matrix();
                (c[0], c[1]) = (c[0] * a[0] + c[1] * a[2], c[0] * a[1] + c[1] * a[3]);
            }
        }
    }

    /// Frequency (Hz) and damping ratio of every pair of poles, by frequency.
    pub fn modes(&self) -> Vec<(f64, f64)> {
        let mut modes: Vec<(f64, f64)> = self
            .blocks
            .iter()
            .filter(|block| block.pair)
            .map(|block| {
                let s = Complex::new(block.parameters[0], block.parameters[1]).ln() / self.step_s;
                (s.norm() / std::f64::consts::TAU, -s.re / s.norm())
            })
            .collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes
    }
}
