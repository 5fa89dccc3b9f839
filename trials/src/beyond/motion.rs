//! A mechanism in motion as a device of the trials: what its nominal equation and an oracle make of a fresh drive.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use twin::dynamic::rig::{Numbers, Rig, find};
use twin::dynamic::{Bench, Excitation};

use super::draw::{Drawn, Truth};
use super::lab::Lab;
use super::plan::{Assignment, Condition, Device};
use crate::linear::{least_squares, norm};

/// Samples of a recording, at 2 kHz.
const SAMPLES: usize = 8192;
/// Least and largest part of the drive's force that is concealed, drawn evenly in the logarithm.
const STRENGTH: [f64; 2] = [0.003, 0.1];
/// The least ρ of what is concealed: as in the trials of the catalogue's motion.
const LEAST_RHO: f64 = 12.0;
/// Steps of a fit.
const FIT_STEPS: usize = 8;

/// One drive of a mechanism.
struct Run {
    drive: Vec<f64>,
    preload: Vec<f64>,
    /// The position without noise.
    clean: Vec<f64>,
}

impl Run {
    fn new(rig: &Rig, numbers: &Numbers, seed: u64) -> Self {
        let (drive, preload) = (rig.bench.drive(seed, 0), rig.preload(seed));
        let clean = rig.positions(numbers, &drive, &preload);
        Self { drive, preload, clean }
    }

    /// The position less that of other numbers.
    fn less(&self, rig: &Rig, position: &[f64], numbers: &Numbers) -> Vec<f64> {
        let simulated = rig.positions(numbers, &self.drive, &self.preload);
        position.iter().zip(simulated).map(|(a, b)| a - b).collect()
    }

    /// The recording with its noise.
    fn lab(self, rig: &Rig, seed: u64, named: bool) -> Lab {
        let measured = rig.read_out(&self.clean, seed);
        let time = |row: usize| row as f64 * rig.bench.sample_s;
        let mut columns = vec![
            ("t_s".to_owned(), (0..measured.len()).map(time).collect()),
            ("drive".to_owned(), self.drive),
            ("position".to_owned(), measured.clone()),
        ];
        if named {
            let newtons = self.preload.iter().map(|part| 40.0 + 15.0 * part).collect();
            columns.push(("preload_n".to_owned(), newtons));
        }
        Lab {
            effect: vec![0.0; measured.len()],
            noise: rig.bench.noise_arcsec,
            reference: "position",
            clean: self.clean,
            measured,
            columns,
        }
    }
}

/// Decimals of a column.
pub fn decimals(column: &str) -> usize {
    match column {
        "position" => 3,
        "preload_n" => 4,
        _ => 6,
    }
}

/// Draws a mechanism and two drives; none where what is concealed cannot be seen or runs away.
pub fn attempt(assignment: &Assignment, file: &str, generator: &mut ChaCha12Rng) -> Option<Drawn> {
    let kind = find(assignment.concealed?.id)?;
    let mut bench = Bench {
        samples: SAMPLES,
        noise: (assignment.family.noise)(),
        ..Bench::from_seed(generator.random())
    };
    bench.model.hold = fitter::plant::Hold::ZeroOrder;
    bench.excitation = match generator.random::<f64>() {
        u if u < 0.6 => Excitation::Multisine { highest_hz: 120.0, odd: false },
        u if u < 0.8 => Excitation::Sweep { lowest_hz: 2.0, highest_hz: 120.0 },
        _ => Excitation::Steps { hold_s: 0.05 },
    };
    let (shaped, seed, fresh_seed) = (generator.random(), generator.random(), generator.random());
    let rig = Rig::new(bench, kind, shaped);
    let [from, to] = STRENGTH.map(f64::ln);
    let truth = rig.numbers((from + (to - from) * generator.random::<f64>()).exp());
    let (seen, fresh) = (Run::new(&rig, &truth, seed), Run::new(&rig, &truth, fresh_seed));
    if seen.clean.iter().chain(&fresh.clean).any(|x| !x.is_finite()) {
        return None;
    }
    let position = rig.read_out(&seen.clean, seed);
    let nominal = fitted(&rig, &seen, &position, rig.numbers(0.0), 3);
    let oracle = fitted(&rig, &seen, &position, truth, 4);
    let rho = norm(&seen.less(&rig, &seen.clean, &nominal)) / rig.bench.noise_arcsec;
    if rho < LEAST_RHO || rho.is_nan() {
        return None;
    }
    let left = |numbers: &Numbers| norm(&fresh.less(&rig, &fresh.clean, numbers)).powi(2) / SAMPLES as f64;
    let (base, oracle) = (left(&nominal), left(&oracle));
    let depends_on = kind.depends_on.iter().map(|name| (*name).to_owned()).collect();
    let named = kind.depends_on.contains(&"preload_n");
    let truth = Truth {
        recording: file.to_owned(),
        device: Device::Motion,
        kind: Some(kind.id.to_owned()),
        left_out: false,
        lasts: true,
        family: assignment.family.name.to_owned(),
        condition: Condition::Plain,
        rho,
        strength: truth[3],
        shape: rig.shape.clone(),
        depends_on,
        noise: rig.bench.noise_arcsec,
        rows: SAMPLES,
    };
    let (seen, fresh) = (seen.lab(&rig, seed, named), fresh.lab(&rig, fresh_seed, named));
    Some(Drawn { truth, seen, fresh, base: Some(base), oracle })
}

/// The first `free` numbers such that the simulated position comes as close as it can to a recorded one (Gauss and
/// Newton's method; a step that does not help is halved).
fn fitted(rig: &Rig, run: &Run, position: &[f64], start: Numbers, free: usize) -> Numbers {
    let (mut numbers, mut left) = (start, run.less(rig, position, &start));
    for _ in 0..FIT_STEPS {
        let columns: Vec<Vec<f64>> = (0..free)
            .map(|index| {
                let mut moved = numbers;
                let step = 1e-4 * numbers[index].abs();
                moved[index] += step;
                let other = run.less(rig, position, &moved);
                left.iter().zip(other).map(|(a, b)| (a - b) / step).collect()
            })
            .collect();
        let steps = least_squares(&columns, &left);
        let tried = (0..6).find_map(|halving| {
            let mut moved = numbers;
            let part = 0.5f64.powi(halving);
            moved.iter_mut().zip(&steps).for_each(|(number, step)| *number += part * step);
            let other = run.less(rig, position, &moved);
            (norm(&other) < norm(&left)).then_some((moved, other))
        });
        let Some((moved, other)) = tried else { break };
        let gained = norm(&left) / norm(&other) - 1.0;
        (numbers, left) = (moved, other);
        if gained < 1e-6 {
            break;
        }
    }
    numbers
}
