//! The linear model with an operator inside the loop, a linear fractional representation:
//! x′ = A x + B u + E w, y = C x + D u + F w, z = C_z x + D_z u, w_l = R(z_l).
//!
//! z is what strains the actuator (its field, its elongation), w what the hysteresis adds to the drive. The
//! linear part may be of any order; nothing but R is nonlinear.

use super::modal::Modal;
use super::operator::{Operator, Response, Runner};
use crate::thresholds::dynamic::linear::looped::UNBOUNDED;

/// The model.
#[derive(Debug, Clone, PartialEq)]
pub struct Looped {
    /// A, B, C and D.
    pub linear: Modal,
    /// E, states × loops.
    pub e: Vec<f64>,
    /// F, outputs × loops.
    pub f: Vec<f64>,
    /// C_z, loops × states.
    pub cz: Vec<f64>,
    /// D_z, loops × inputs.
    pub dz: Vec<f64>,
    /// R.
    pub operator: Operator,
}

/// Rows that are simulated or fitted together: one period in steady state, or a stretch of any recording.
#[derive(Debug, Clone)]
pub struct Stretch {
    /// Drives, rows × inputs.
    pub drive: Vec<f64>,
    /// Positions, rows × outputs.
    pub position: Vec<f64>,
    /// Whether the rows repeat for ever.
    pub periodic: bool,
    /// Rows at the start that are not scored.
    pub skip: usize,
    /// Factor of its residuals.
    pub weight: f64,
}

impl Stretch {
    /// Number of rows.
    pub fn rows(&self, inputs: usize) -> usize {
        self.drive.len() / inputs.max(1)
    }
}

/// State of a simulation: x, then the memory of every loop.
#[derive(Debug, Clone)]
pub struct State {
    /// State of the linear part.
    pub x: Vec<f64>,
    /// Memory cells, loops × cells.
    pub memory: Vec<f64>,
}

impl Looped {
    /// A linear model without a loop.
    pub fn plain(linear: Modal) -> Looped {
        let operator = Operator::memoryless(0.0);
        Looped { linear, e: vec![], f: vec![], cz: vec![], dz: vec![], operator }
    }

    /// Number of loops.
    pub fn loops(&self) -> usize {
        self.dz.len() / self.linear.inputs.max(1)
    }

    /// Parameters: those of the linear part, then E, F, C_z, D_z by rows and the exponent.
    pub fn parameters(&self) -> Vec<f64> {
        let mut all = self.linear.parameters();
        if self.loops() > 0 {
            for part in [&self.e, &self.f, &self.cz, &self.dz] {
                all.extend(part);
            }
            all.push(self.operator.exponent);
        }
        all
    }

    /// The same structure with other parameters.
    pub fn with(&self, parameters: &[f64]) -> Looped {
        let mut rest = parameters;
        let mut take = |count: usize| {
            let (now, later) = rest.split_at(count);
            rest = later;
            now.to_vec()
        };
        let lin = &self.linear;
        let linear = lin.with(&take(lin.order() + lin.b.len() + lin.c.len() + lin.d.len()));
        if self.loops() == 0 {
            return Looped { linear, ..self.clone() };
        }
        let (e, f) = (take(self.e.len()), take(self.f.len()));
        let (cz, dz) = (take(self.cz.len()), take(self.dz.len()));
        let operator = Operator { exponent: take(1)[0], ..self.operator.clone() };
        Looped { linear, e, f, cz, dz, operator }
    }

    /// The same structure with so many times what its loop adds.
    pub fn of_strength(&self, part: f64) -> Looped {
        let scaled = |values: &[f64]| values.iter().map(|value| part * value).collect();
        Looped { e: scaled(&self.e), f: scaled(&self.f), ..self.clone() }
    }

    /// The state at rest.
    pub fn rest(&self) -> State {
        State { x: vec![0.0; self.linear.order()], memory: vec![0.0; self.loops() * self.operator.cells()] }
    }

    /// Simulates freely over `drive` (rows × inputs) from `state`, which is left at the end; positions, rows
    /// × outputs. `None` where the simulation runs away.
    pub fn simulate(&self, drive: &[f64], state: &mut State) -> Option<Vec<f64>> {
        let m = self.linear.inputs;
        let mut y = Vec::with_capacity(drive.len() / m.max(1) * self.linear.outputs);
        let mut step = Stepper::new(self);
        for u in drive.chunks_exact(m) {
            step.run(self, u, state, &mut y);
            if !y[y.len() - self.linear.outputs..].iter().all(|v| v.abs() < UNBOUNDED) {
                return None;
            }
        }
        Some(y)
    }

    /// The positions of a periodic drive in steady state, over one period of rows.
    pub fn steady(&self, drive: &[f64]) -> Option<Vec<f64>> {
        let mut state = self.rest();
        for _ in 0..self.settling(drive.len() / self.linear.inputs.max(1)) {
            self.simulate(drive, &mut state)?;
        }
        self.simulate(drive, &mut state)
    }

    /// Periods of `rows` rows after which a transient has decayed by 10⁻⁶, between 1 and 20.
    pub fn settling(&self, rows: usize) -> usize {
        let radius = self.linear.blocks.iter().map(|b| b.radius()).fold(0.0, f64::max);
        let decay = -radius.clamp(1e-9, 0.999_999).ln() * rows as f64;
        ((1e6f64.ln() / decay).ceil() as usize).clamp(1, 20)
    }
}

/// One step of the model, with room for its intermediate values.
pub struct Stepper {
    runner: Runner,
    next: Vec<f64>,
    /// w of the last step.
    pub w: Vec<f64>,
    /// All that the operators gave.
    pub responses: Vec<Response>,
}

impl Stepper {
    /// For `model`.
    pub fn new(model: &Looped) -> Stepper {
        let q = model.loops();
        Stepper {
            runner: Runner::new(&model.operator),
            next: vec![0.0; model.linear.order()],
            w: vec![0.0; q],
            responses: vec![Response::default(); q],
        }
    }

    /// Weights of the plays.
    pub fn weights(&self) -> &[f64] {
        &self.runner.weights
    }

    /// Appends the positions at drive `u` to `y` and advances `state`.
    pub fn run(&mut self, model: &Looped, u: &[f64], state: &mut State, y: &mut Vec<f64>) {
        let lin = &model.linear;
        let (n, m, q) = (lin.order(), lin.inputs, model.loops());
        let cells = model.operator.cells();
        for l in 0..q {
            let z =
                product(&model.cz[l * n..(l + 1) * n], &state.x) + product(&model.dz[l * m..(l + 1) * m], u);
            let r = self.runner.step(z, &mut state.memory[l * cells..(l + 1) * cells]);
            (self.w[l], self.responses[l]) = (r.value, r);
        }
        for i in 0..lin.outputs {
            y.push(
                product(&lin.c[i * n..(i + 1) * n], &state.x)
                    + product(&lin.d[i * m..(i + 1) * m], u)
                    + if q > 0 { product(&model.f[i * q..(i + 1) * q], &self.w) } else { 0.0 },
            );
        }
        lin.advance(&state.x, u, &mut self.next);
        if q > 0 {
            for (next, e) in self.next.iter_mut().zip(model.e.chunks_exact(q)) {
                *next += product(e, &self.w);
            }
        }
        std::mem::swap(&mut state.x, &mut self.next);
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
