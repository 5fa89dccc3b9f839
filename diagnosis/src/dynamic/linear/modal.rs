//! A multivariable linear state space in modal form: A of 2 × 2 blocks, so that a sample costs 2 n products
//! and every pole is a parameter.

use crate::dynamic::spectrum::Complex;
use crate::thresholds::dynamic::linear::modal::STABLE;

/// One 2 × 2 block of A, with two parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Block {
    /// Poles `re ± i·im`: `[[re, im], [−im, re]]`.
    Pair { re: f64, im: f64 },
    /// Two real poles: `diag(first, second)`.
    Real { first: f64, second: f64 },
}

impl Block {
    /// The block by rows.
    pub fn matrix(self) -> [f64; 4] {
        match self {
            Block::Pair { re, im } => [re, im, -im, re],
            Block::Real { first, second } => [first, 0.0, 0.0, second],
        }
    }

    /// Derivatives of the block, by rows, with respect to its two parameters.
    pub fn derivatives(self) -> [[f64; 4]; 2] {
        match self {
            Block::Pair { .. } => [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, -1.0, 0.0]],
            Block::Real { .. } => [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
        }
    }

    /// Largest modulus of its poles.
    pub fn radius(self) -> f64 {
        match self {
            Block::Pair { re, im } => re.hypot(im),
            Block::Real { first, second } => first.abs().max(second.abs()),
        }
    }

    /// The parameters.
    pub fn parameters(self) -> [f64; 2] {
        match self {
            Block::Pair { re, im } => [re, im],
            Block::Real { first, second } => [first, second],
        }
    }

    /// The same kind of block with other parameters.
    pub fn with(self, p: [f64; 2]) -> Block {
        match self {
            Block::Pair { .. } => Block::Pair { re: p[0], im: p[1] },
            Block::Real { .. } => Block::Real { first: p[0], second: p[1] },
        }
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
        let blocks = self.blocks.iter().flat_map(|b| b.parameters());
        blocks.chain(self.b.iter().chain(&self.c).chain(&self.d).copied()).collect()
    }

    /// The same structure with other parameters (as many as [`Modal::parameters`] gives).
    pub fn with(&self, parameters: &[f64]) -> Modal {
        let (n, nb, nc) = (self.order(), self.b.len(), self.c.len());
        let blocks =
            self.blocks.iter().zip(parameters.chunks_exact(2)).map(|(b, p)| b.with([p[0], p[1]])).collect();
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

    /// Frequency (Hz) and damping ratio of every pair of poles, by frequency.
    pub fn modes(&self) -> Vec<(f64, f64)> {
        let mut modes: Vec<(f64, f64)> = self
            .blocks
            .iter()
            .filter_map(|block| match *block {
                Block::Pair { re, im } => {
                    let s = Complex::new(re, im).ln() / self.step_s;
                    Some((s.norm() / std::f64::consts::TAU, -s.re / s.norm()))
                }
                Block::Real { .. } => None,
            })
            .collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes
    }
}
