//! A multivariable linear plant from sample to sample, with what may stand before its drives and behind its
//! positions.

use fitter::plant::{Hold, Numbers, PlantEffect, StateSpace};

use super::effects::Context;
use super::effects::catalogue::{ON_DRIVES, ON_READ_OUT};
use super::error::RunError;
use super::linear_loop::{Loops, dot, is_loop};
use super::model::{Model, Start};

/// A linear plant.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearModel {
    /// Its matrices.
    pub space: StateSpace,
    /// Effects on the way of the drives and of the read-out.
    pub effects: Vec<PlantEffect>,
    /// How the drives run between their samples, where an effect needs to know.
    pub hold: Hold,
}

impl LinearModel {
    /// The positions at every sample of the drives, each a column.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn simulate(
        &self,
        drives: &[Vec<f64>],
        sample_s: f64,
        start: Start,
    ) -> Result<Vec<Vec<f64>>, RunError> {
        let (states, inputs, outputs) = self.space.sizes();
        if drives.len() != inputs {
            return Err(RunError::Drives { expected: inputs, found: drives.len() });
        }
        // Printed times are rounded; a rate that is really another differs by far more.
        if (sample_s / self.space.sample_time_s - 1.0).abs() > 1e-3 {
            return Err(RunError::Rate { expected: self.space.sample_time_s, found: sample_s });
        }
        let known = |e: &&PlantEffect| !ON_DRIVES.contains(&&*e.id) && !ON_READ_OUT.contains(&&*e.id);
        if let Some(effect) = self.effects.iter().find(known) {
            return Err(RunError::Inertia { id: effect.id.clone() });
        }
        let sample_s = self.space.sample_time_s;
        let passed = drives
            .iter()
            .enumerate()
            .map(|(index, drive)| self.pass(index, drive, sample_s, start, &ON_DRIVES))
            .collect::<Result<Vec<_>, _>>()?;
        let count = drives.first().map_or(0, Vec::len);
        let mut inside =
            Loops::of(&self.effects, states, inputs, outputs).map_err(|reason| RunError::Loop { reason })?;
        let driven = |row: usize| -> Vec<f64> { passed.iter().map(|u| u[row]).collect() };
        let mut state = vec![0.0; states];
        if let Start::Steady { period } = start {
            for _ in 0..200 {
                let before = state.clone();
                for row in 0..period.min(count) {
                    let u = driven(row);
                    let w = inside.output(&state, &u);
                    state = self.next(&state, &u, &inside, &w);
                }
                let size = state.iter().fold(f64::MIN_POSITIVE, |most, z| z.abs().max(most));
                let moved = state.iter().zip(&before).fold(0.0, |most: f64, (a, b)| (a - b).abs().max(most));
                if moved < 1e-10 * size || !size.is_finite() {
                    break;
                }
            }
        }
        let mut positions = vec![Vec::with_capacity(count); outputs];
        for row in 0..count {
            let u = driven(row);
            let w = inside.output(&state, &u);
            for (output, column) in positions.iter_mut().enumerate() {
                let StateSpace { c, d, .. } = &self.space;
                column.push(
                    dot(&c[output], &state) + dot(&d[output], &u) + inside.adds_to_position(output, &w),
                );
            }
            state = self.next(&state, &u, &inside, &w);
            if state.iter().any(|z| !z.is_finite() || z.abs() > 1e30) {
                return Err(RunError::Unstable { row });
            }
        }
        positions.iter().map(|position| self.pass(0, position, sample_s, start, &ON_READ_OUT)).collect()
    }

    fn next(&self, state: &[f64], u: &[f64], inside: &Loops, w: &[f64]) -> Vec<f64> {
        let rows = self.space.a.iter().zip(&self.space.b).enumerate();
        rows.map(|(k, (a, b))| dot(a, state) + dot(b, u) + inside.adds_to_state(k, w)).collect()
    }

    /// What the effects of `among` make of a signal: a mechanism that does not move carries them.
    fn pass(
        &self,
        index: usize,
        signal: &[f64],
        sample_s: f64,
        start: Start,
        among: &[&str],
    ) -> Result<Vec<f64>, RunError> {
        let effects: Vec<PlantEffect> = self
            .effects
            .iter()
            .filter(|effect| among.contains(&&*effect.id) && !is_loop(effect))
            .map(|effect| PlantEffect {
                // A signal behind the mechanism is filtered as one before it.
                id: effect.id.replace("sensor_", "drive_"),
                parameters: effect
                    .parameters
                    .iter()
                    .map(|(name, value)| (name.clone(), value.get(index).map_or(value.clone(), Numbers::One)))
                    .collect(),
            })
            .collect();
        if effects.is_empty() {
            return Ok(signal.to_vec());
        }
        let carrier = Model {
            damping: 0.0,
            stiffness: 0.0,
            gains: vec![0.0],
            effects,
            hold: self.hold,
            context: Context { feedback: false },
        };
        carrier.path(signal, sample_s, start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_order(effects: Vec<PlantEffect>) -> LinearModel {
        let space = StateSpace {
            sample_time_s: 1e-3,
            a: vec![vec![0.9]],
            b: vec![vec![0.1, 0.0]],
            c: vec![vec![1.0], vec![0.0]],
            d: vec![vec![0.0, 0.0], vec![0.0, 2.0]],
        };
        LinearModel { space, effects, hold: Hold::ZeroOrder }
    }

    #[test]
    fn a_step_through_the_matrices() {
        let start = Start::At { position: 0.0, velocity: 0.0 };
        let drives = [vec![1.0; 50], vec![3.0; 50]];
        let [x, y] = &first_order(Vec::new()).simulate(&drives, 1e-3, start).unwrap()[..] else { panic!() };
        assert!(x.iter().enumerate().all(|(k, x)| (x - 1.0 + 0.9f64.powi(k as i32)).abs() < 1e-12));
        assert!(y.iter().all(|y| *y == 6.0));
        let steady = first_order(Vec::new()).simulate(&drives, 1e-3, Start::Steady { period: 50 }).unwrap();
        assert!(steady[0].iter().all(|x| (x - 1.0).abs() < 1e-8));
    }

    #[test]
    fn effects_of_the_drives_and_of_the_read_out() {
        let start = Start::At { position: 0.0, velocity: 0.0 };
        let effects = vec![
            PlantEffect::new("drive_saturation", &[("limit", 0.5)]),
            PlantEffect::new("sensor_offset", &[("offset", 7.0)]),
        ];
        let drives = [vec![1.0; 200], vec![0.25; 200]];
        let out = first_order(effects).simulate(&drives, 1e-3, start).unwrap();
        assert!((out[0][199] - 7.5).abs() < 1e-6 && (out[1][199] - 7.5).abs() < 1e-6);
        let stiff = first_order(vec![PlantEffect::new("cubic_stiffness", &[("coefficient", 1.0)])]);
        assert!(stiff.simulate(&drives, 1e-3, start).unwrap_err().to_string().contains("inertia"));
        let slow = first_order(Vec::new()).simulate(&drives, 2e-3, start).unwrap_err().to_string();
        assert!(slow.contains("0.002"), "{slow}");
    }
}
