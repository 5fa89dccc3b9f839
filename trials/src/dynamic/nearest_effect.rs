//! What an effect adds to a recording, and which other effect comes closest to it: the recording can tell the two
//! only by what that leaves.

use std::f64::consts::FRAC_PI_2;

use fitter::plant::PlantEffect;
use fitter::table::Values;
use rand_chacha::ChaCha12Rng;
use twin::dynamic::effects::{Specification, catalogue};
use twin::dynamic::{Bench, Typical};

use super::draw::drawn_effect;
use super::matched::Whitener;
use super::plan::known_in_free_run;
use crate::linear::{Basis, dot, norm};

/// Parts by which the plant's damping, stiffness and gain are changed to see what that changes.
const CHANGES: [f64; 3] = [0.002, 0.001, 0.001];
/// Draws of the shape of an effect that is tried in place of another.
const SHAPES: usize = 2;
/// Strength of what is tried at first.
const TRIED: f64 = 0.02;
/// Corrections of strength and plant: a lag of a few per cent and the plant that takes it up are no small changes.
const CORRECTIONS: usize = 4;

/// Part of a column's norm below which what other columns leave of it is rounding, of the simulations above all.
const DEPENDENT: f64 = 1e-7;

/// A mechanism with effects in it.
pub struct Scene<'a> {
    pub effects: &'a [PlantEffect],
    /// What each of them adds to the position beside the others.
    pub added: Vec<Vec<f64>>,
    bare: &'a Bench,
    seed: u64,
    clean: &'a [f64],
    typical: &'a Typical,
    whitener: Whitener,
    /// What the changes of the plant's numbers take from the position, whitened.
    plant: Vec<Vec<f64>>,
    /// How the plant swings after another beginning, whitened: nobody knows where it began.
    beginnings: Vec<Vec<f64>>,
    /// `added`, whitened.
    white: Vec<Vec<f64>>,
}

/// The positions without noise.
pub fn positions(bench: &Bench, seed: u64) -> Option<Values> {
    bench.record_noiseless(seed).ok().and_then(|series| series.positions.into_iter().next())
}

impl<'a> Scene<'a> {
    /// The mechanism `bare` with `effects` in it, which is `bench`, and its positions `clean`; none where it cannot
    /// be simulated without one of them.
    pub fn new(
        bare: &'a Bench,
        bench: &Bench,
        seed: u64,
        effects: &'a [PlantEffect],
        clean: &'a [f64],
        typical: &'a Typical,
    ) -> Option<Self> {
        let whitener = Whitener::of(bench);
        let mut scene = Scene {
            effects,
            added: Vec::new(),
            bare,
            seed,
            clean,
            typical,
            whitener,
            plant: Vec::new(),
            beginnings: Vec::new(),
            white: Vec::new(),
        };
        if effects.is_empty() {
            return Some(scene);
        }
        for number in 0..CHANGES.len() {
            let mut parts = [0.0; 3];
            parts[number] = CHANGES[number];
            scene.plant.push(scene.against(&changed(bench, parts))?);
        }
        scene.beginnings =
            [0.0, FRAC_PI_2].map(|phase| scene.whitener.whiten(&swing(bare, clean.len(), phase))).into();
        for index in 0..effects.len() {
            let without = positions(&bare.with_effects(scene.others(index)).ok()?, seed)?;
            scene.added.push(clean.iter().zip(&without).map(|(a, b)| a - b).collect());
        }
        scene.white = scene.added.iter().map(|column| scene.whitener.whiten(column)).collect();
        Some(scene)
    }

    /// What an effect adds, whitened.
    pub fn white(&self, index: usize) -> &[f64] {
        &self.white[index]
    }

    /// What other numbers of the plant and another beginning could take up.
    pub fn nominal(&self) -> Basis {
        basis(self.plant.iter().chain(&self.beginnings))
    }

    /// The same, and what the other effects could.
    pub fn beside(&self, index: usize) -> Basis {
        basis(self.columns(index))
    }

    fn columns(&self, index: usize) -> impl Iterator<Item = &Vec<f64>> {
        let others = self.white.iter().enumerate().filter(move |(i, _)| *i != index);
        self.plant.iter().chain(&self.beginnings).chain(others.map(|(_, column)| column))
    }

    fn others(&self, index: usize) -> Vec<PlantEffect> {
        let mut others = self.effects.to_vec();
        others.remove(index);
        others
    }

    /// What the effects add for each part by which they grow, whitened, from the same effects `part` weaker: where much of an
    /// effect acts, this is not what all of it adds.
    pub fn growth(&self, weaker: Vec<PlantEffect>, part: f64) -> Option<Vec<f64>> {
        let mut growth = self.against(&self.bare.with_effects(weaker).ok()?)?;
        growth.iter_mut().for_each(|x| *x /= part);
        Some(growth)
    }

    /// The positions less those of another mechanism, whitened.
    fn against(&self, other: &Bench) -> Option<Vec<f64>> {
        let other = positions(other, self.seed)?;
        let apart: Vec<f64> = self.clean.iter().zip(&other).map(|(a, b)| a - b).collect();
        Some(self.whitener.whiten(&apart))
    }

    /// The effect of the table that comes closest to the one at `index`, in its place, and ρ of what it leaves of
    /// `rest`.
    pub fn closest(&self, index: usize, rest: &[f64], generator: &mut ChaCha12Rng) -> Option<(String, f64)> {
        let beside = self.beside(index);
        let taken: Vec<&str> = self.effects.iter().map(|e| e.id.as_str()).collect();
        let tried = catalogue::ALL
            .iter()
            .filter(|s| known_in_free_run(s) == Some(true) && !taken.contains(&s.id))
            .flat_map(|s| {
                // Only what has a shape beside its strength differs from draw to draw.
                let shapes = if s.parameters.len() > 1 { SHAPES } else { 1 };
                (0..shapes).map(move |_| s)
            });
        let (specification, shape, column, left) = tried
            .filter_map(|specification| {
                let shape = generator.clone();
                let with = self.with(index, specification, TRIED, generator, [0.0; 3])?;
                let column: Vec<f64> = self.white[index].iter().zip(with).map(|(a, b)| a - b).collect();
                let mut wider = beside.clone();
                wider.push_beyond(&column, DEPENDENT);
                let left = norm(&wider.projected_off(rest));
                Some((specification, shape, column, left))
            })
            .min_by(|a, b| a.3.total_cmp(&b.3))?;
        let corrected = self.corrected(index, specification, &shape, &column);
        Some((specification.id.to_owned(), corrected.map_or(left, |corrected| corrected.min(left))))
    }

    /// The positions less those with an effect in the place of the one at `index`, its shape drawn by `generator`,
    /// beside a plant whose numbers are changed by parts; whitened.
    fn with(
        &self,
        index: usize,
        specification: &Specification,
        strength: f64,
        generator: &mut ChaCha12Rng,
        parts: [f64; 3],
    ) -> Option<Vec<f64>> {
        let mut effects = self.others(index);
        effects.push(drawn_effect(specification, strength, self.typical, generator));
        self.against(&changed(&self.bare.with_effects(effects).ok()?, parts))
    }

    /// ρ of what an effect leaves whose strength, and the plant's numbers with it, were corrected for what the
    /// comparison of small changes neglects; `column` is what it adds at the strength at which it was tried.
    fn corrected(
        &self,
        index: usize,
        specification: &Specification,
        shape: &ChaCha12Rng,
        column: &Vec<f64>,
    ) -> Option<f64> {
        let columns: Vec<&Vec<f64>> = self.columns(index).chain([column]).collect();
        let all = basis(columns.iter().copied());
        let (mut parts, mut strength) = ([0.0; 3], 0.0);
        let mut target = self.white[index].clone();
        let mut least = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            for (part, (number, change)) in parts.iter_mut().zip(CHANGES.iter().enumerate()) {
                *part -= change * along(&columns, number, &target);
            }
            strength += TRIED * along(&columns, columns.len() - 1, &target);
            if strength.is_nan() || strength <= 0.0 {
                break;
            }
            target = self.with(index, specification, strength, &mut shape.clone(), parts)?;
            least = least.min(norm(&all.projected_off(&target)));
        }
        Some(least)
    }
}

/// The free swing of the plant over some rows.
fn swing(bench: &Bench, rows: usize, phase: f64) -> Vec<f64> {
    let half = 0.5 * bench.model.damping;
    let omega = (bench.model.stiffness - half * half).max(0.0).sqrt();
    let at = |row: usize| row as f64 * bench.sample_s;
    (0..rows).map(|row| (-half * at(row)).exp() * (omega * at(row) + phase).cos()).collect()
}

/// A mechanism with the plant's numbers changed by parts of them.
fn changed(bench: &Bench, [damping, stiffness, gain]: [f64; 3]) -> Bench {
    let mut changed = bench.clone();
    changed.model.damping *= 1.0 + damping;
    changed.model.stiffness *= 1.0 + stiffness;
    changed.model.gains.iter_mut().for_each(|g| *g *= 1.0 + gain);
    changed
}

fn basis<'b>(columns: impl Iterator<Item = &'b Vec<f64>>) -> Basis {
    let mut basis = Basis::default();
    columns.for_each(|column| basis.push_beyond(column, DEPENDENT));
    basis
}

/// How much of a column is in a target beside the other columns: its coefficient in their least squares.
fn along(columns: &[&Vec<f64>], index: usize, target: &[f64]) -> f64 {
    let others = columns.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, column)| *column);
    let own = basis(others).projected_off(columns[index]);
    let square = dot(&own, &own);
    if square > 0.0 { dot(&own, target) / square } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_is_that_of_least_squares() {
        let (a, b) = (vec![1.0, 0.0, 1.0], vec![1.0, 1.0, 0.0]);
        // 2 a − 3 b, and something that neither spans.
        let target = [2.0 - 3.0 + 1.0, -3.0 - 1.0, 2.0 - 1.0];
        assert!((along(&[&a, &b], 0, &target) - 2.0).abs() < 1e-12);
        assert!((along(&[&a, &b], 1, &target) + 3.0).abs() < 1e-12);
    }

    /// A lag of a tenth before a linear mechanism is the same behind it, once the plant's numbers are corrected.
    #[test]
    fn a_strong_lag_is_imitated_behind_the_mechanism() {
        let bare = Bench { samples: 4096, ..Bench::from_seed(3) };
        let typical = bare.typical(8);
        let lag = PlantEffect::new("sensor_lag", &[("time_constant_s", 0.08 / typical.corner_rad_per_s())]);
        let bench = bare.with_effects(vec![lag.clone()]).unwrap();
        let clean = positions(&bench, 8).unwrap();
        let effects = [lag];
        let scene = Scene::new(&bare, &bench, 8, &effects, &clean, &typical).unwrap();
        let rest = scene.beside(0).projected_off(scene.white(0));
        let mut generator = rand_chacha::rand_core::SeedableRng::seed_from_u64(1);
        let (id, left) = scene.closest(0, &rest, &mut generator).unwrap();
        assert_eq!(id, "drive_lag");
        assert!(left < 0.01 * norm(&rest), "{left} of {}", norm(&rest));
    }
}
