//! The operator inside the loop: hysteresis with return-point memory, or its rival without memory.
//!
//! Hysteresis is a bank of play operators p_r of thresholds r, w = Σ g(r) p_r(z) Δr: Preisach's operator of
//! the Prandtl–Ishlinskii class. Uniform g is Rayleigh's law: on the virgin curve w = z²/2, from a reversal
//! Δw = Δz²/4, the gain grows in proportion to the amplitude and every loop encloses its area (Lord
//! Rayleigh, Phil. Mag. 23 (1887) 225; for ferroelectrics D. Damjanovic, J. Appl. Phys. 82 (1997) 1788).
//! g(r) = r^e departs from it by one exponent: the gain grows with amplitude to the power 1 + e.

use crate::thresholds::dynamic::linear::operator::PLAYS;

/// What stands inside the loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    /// Half-widths r of the plays, increasing; without any it is w = z |z|^(1+e): the same growth of the gain with
    /// amplitude, without memory and without loss.
    pub thresholds: Vec<f64>,
    /// Width Δr of the band of thresholds that each stands for.
    pub spacing: Vec<f64>,
    /// e in g(r) = r^e; 0 is Rayleigh's law.
    pub exponent: f64,
}

impl Operator {
    /// The bank of plays for signals of about unit size.
    pub fn hysteresis(exponent: f64) -> Operator {
        let ratio = (2.0f64 / 0.01).powf(1.0 / (PLAYS - 1) as f64);
        let mut edges = vec![0.0];
        edges.extend((0..PLAYS).map(|k| 0.01 * ratio.powi(k as i32)));
        let thresholds = edges.windows(2).map(|e| 0.5 * (e[0] + e[1])).collect();
        let spacing = edges.windows(2).map(|e| e[1] - e[0]).collect();
        Operator { thresholds, spacing, exponent }
    }

    /// The rival without memory.
    pub fn memoryless(exponent: f64) -> Operator {
        Operator { thresholds: vec![], spacing: vec![], exponent }
    }

    /// Weight g(r) Δr of every play.
    pub fn weights(&self) -> Vec<f64> {
        self.thresholds.iter().zip(&self.spacing).map(|(r, d)| r.powf(self.exponent) * d).collect()
    }

    /// Number of memory cells of one signal.
    pub fn cells(&self) -> usize {
        self.thresholds.len()
    }
}

/// The operator made ready for running: weights and their derivatives worked out once.
pub struct Runner {
    thresholds: Vec<f64>,
    /// g(r) Δr.
    pub weights: Vec<f64>,
    slopes: Vec<f64>,
    exponent: f64,
}

/// What one evaluation gives beside the output.
#[derive(Clone, Copy, Default)]
pub struct Response {
    pub value: f64,
    /// ∂w/∂e at a fixed signal.
    pub by_exponent: f64,
    /// dw/dz where there is no memory.
    pub slope: f64,
    /// Plays that moved, a bit each.
    pub moved: u32,
}

impl Runner {
    /// Makes `operator` ready.
    pub fn new(operator: &Operator) -> Runner {
        let (weights, thresholds) = (operator.weights(), operator.thresholds.clone());
        let slopes = weights.iter().zip(&thresholds).map(|(w, r)| w * r.ln()).collect();
        Runner { thresholds, weights, slopes, exponent: operator.exponent }
    }

    /// Advances the memory by the signal's next value.
    pub fn step(&self, z: f64, memory: &mut [f64]) -> Response {
        if self.thresholds.is_empty() {
            let size = z.abs().max(1e-12);
            let power = size.powf(1.0 + self.exponent);
            let value = z * power;
            return Response {
                value,
                by_exponent: value * size.ln(),
                slope: (2.0 + self.exponent) * power,
                moved: 0,
            };
        }
        let mut out = Response::default();
        for (k, play) in memory.iter_mut().enumerate() {
            let r = self.thresholds[k];
            let next = play.clamp(z - r, z + r);
            if next != *play {
                out.moved |= 1 << k;
                *play = next;
            }
            out.value += self.weights[k] * next;
            out.by_exponent += self.slopes[k] * next;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(operator: &Operator, signal: impl Iterator<Item = f64>) -> Vec<f64> {
        let runner = Runner::new(operator);
        let mut memory = vec![0.0; operator.cells()];
        signal.map(|z| runner.step(z, &mut memory).value).collect()
    }

    #[test]
    fn a_uniform_bank_is_rayleighs_law() {
        let fine = Operator {
            thresholds: (0..400).map(|k| (k as f64 + 0.5) / 400.0).collect(),
            spacing: vec![1.0 / 400.0; 400],
            exponent: 0.0,
        };
        let runner = Runner {
            thresholds: fine.thresholds.clone(),
            weights: fine.weights(),
            slopes: vec![0.0; 400],
            exponent: 0.0,
        };
        let mut memory = vec![0.0; 400];
        let mut w = 0.0;
        for n in 0..=100 {
            // Only the first 32 plays fit into the mask; the value does not depend on it.
            w = step_value(&runner, 0.8 * n as f64 / 100.0, &mut memory);
        }
        assert!((w - 0.32).abs() < 1e-3, "virgin curve z²/2: {w}");
        let top = w;
        for n in 0..=100 {
            w = step_value(&runner, 0.8 - 1.0 * n as f64 / 100.0, &mut memory);
        }
        assert!((top - w - 0.25).abs() < 1e-3, "reversal Δz²/4: {}", top - w);
    }

    fn step_value(runner: &Runner, z: f64, memory: &mut [f64]) -> f64 {
        memory
            .iter_mut()
            .zip(runner.thresholds.iter().zip(&runner.weights))
            .map(|(p, (r, g))| {
                *p = p.clamp(z - r, z + r);
                g * *p
            })
            .sum()
    }

    #[test]
    fn loops_enclose_area_only_with_memory() {
        let sine = |n: usize| (std::f64::consts::TAU * n as f64 / 200.0).sin();
        for (operator, encloses) in [(Operator::hysteresis(0.0), true), (Operator::memoryless(0.0), false)] {
            let w = run(&operator, (0..600).map(sine));
            let area: f64 = (200..400).map(|n| w[n] * (sine(n + 1) - sine(n - 1)) / 2.0).sum();
            assert_eq!(area.abs() > 0.05, encloses, "{operator:?}: {area}");
        }
    }
}
