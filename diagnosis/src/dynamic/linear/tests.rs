//! Made structures with known answers.

use std::ops::Range;

use super::looped::{Looped, Stretch};
use super::modal::{Block, Modal};
use super::operator::Operator;
use super::plan::Plan;
use super::{nominal, sensitivity};
use crate::dynamic::DynamicRecording;

const PERIOD: usize = 1024;

/// Two modes at 40 and 95 Hz of a structure with two drives and two positions, sampled at 1 kHz.
fn structure() -> Modal {
    let pole = |frequency: f64, damping: f64| {
        let w = std::f64::consts::TAU * frequency * 1e-3;
        let radius = (-damping * w).exp();
        Block { pair: true, parameters: [radius * w.cos(), radius * w.sin()] }
    };
    Modal {
        inputs: 2,
        outputs: 2,
        step_s: 1e-3,
        blocks: vec![pole(40.0, 0.02), pole(95.0, 0.03)],
        b: vec![0.3, 0.1, 0.2, -0.1, -0.2, 0.4, 0.1, 0.2],
        c: vec![1.0, 0.2, -0.5, 0.3, 0.4, 0.5, 0.9, -0.2],
        d: vec![0.0; 4],
    }
}

/// A plain generator: the tests need repeatable numbers, no good ones.
struct Numbers(u64);

impl Numbers {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Four runs of two periods at each amplitude, random-phase multisines up to 200 Hz, white noise.
fn record(model: &Looped, amplitudes: &[f64], noise: f64) -> DynamicRecording {
    let mut numbers = Numbers(7);
    let (mut drives, mut positions) = (vec![vec![]; 2], vec![vec![]; 2]);
    let (mut runs, mut period, mut amplitude): (Vec<Range<usize>>, Vec<i64>, Vec<f64>) = Default::default();
    for &size in amplitudes {
        for _ in 0..4 {
            let tones: Vec<Vec<f64>> = (0..2)
                .map(|_| (0..205).map(|_| numbers.uniform() * std::f64::consts::TAU).collect())
                .collect();
            let drive: Vec<f64> = (0..PERIOD)
                .flat_map(|n| {
                    let t = std::f64::consts::TAU * n as f64 / PERIOD as f64;
                    tones.iter().map(move |phases| {
                        let sum: f64 =
                            phases.iter().enumerate().map(|(k, p)| ((k + 1) as f64 * t + p).cos()).sum();
                        size * sum / (205f64 / 2.0).sqrt()
                    })
                })
                .collect();
            let y = model.steady(&drive).unwrap();
            let start = period.len();
            for turn in 0..2 {
                for n in 0..PERIOD {
                    for k in 0..2 {
                        drives[k].push(drive[2 * n + k]);
                        positions[k].push(y[2 * n + k] + noise * numbers.normal());
                    }
                    period.push(turn);
                    amplitude.push(size);
                }
            }
            runs.push(start..period.len());
        }
    }
    DynamicRecording {
        drives: drives.into_iter().map(Into::into).collect(),
        positions: positions.into_iter().map(Into::into).collect(),
        runs,
        period: Some(period.clone()),
        amplitude: Some(amplitude.into()),
        ..DynamicRecording::made(1e-3, vec![0.0; period.len()], Vec::new())
    }
}

/// The structure with hysteresis between drive and force, w = R(u).
fn hysteretic(strength: f64) -> Looped {
    let linear = structure();
    let scaled = |values: &[f64]| values.iter().map(|v| strength * v).collect::<Vec<f64>>();
    Looped {
        e: scaled(&linear.b),
        f: scaled(&linear.d),
        cz: vec![0.0; 8],
        dz: vec![1.0, 0.0, 0.0, 1.0],
        operator: Operator::hysteresis(0.0),
        linear,
    }
}

#[test]
fn order_and_response_of_a_known_structure_are_found() {
    let truth = structure();
    let recording = record(&Looped::plain(truth.clone()), &[1.0], 0.01);
    let plan = Plan::new(&recording);
    assert_eq!(plan.period, Some(PERIOD));
    let data = plan.experiments(&recording, &plan.fitted());
    let held = plan.experiments(&recording, &plan.held());
    assert_eq!(nominal::choose_order(&data, Some(&held)), Some(4));
    let found = nominal::identify(&data, 4).unwrap();
    for (found, truth) in found.modes().iter().zip(truth.modes()) {
        assert!((found.0 / truth.0 - 1.0).abs() < 1e-3 && (found.1 / truth.1 - 1.0).abs() < 0.03);
    }
}

/// What hysteresis makes of the response at several amplitudes is no linear model's, and hides a weak mode in the error.
#[test]
fn more_amplitudes_do_not_hide_a_weak_mode() {
    let mut truth = hysteretic(0.4);
    truth.linear.b[4..].iter_mut().for_each(|b| *b *= 0.15);
    truth.e[4..].iter_mut().for_each(|e| *e *= 0.15);
    let recording = record(&truth, &[0.1, 0.4, 1.0], 1e-4);
    let plan = Plan::new(&recording);
    let data = plan.experiments(&recording, &plan.fitted());
    let held = plan.experiments(&recording, &plan.groups[0].held);
    let [two, four] = [2, 4].map(|order| nominal::error(&nominal::identify(&data, order).unwrap(), &data));
    assert!(two < 1.15 * four, "the error alone, {two} beside {four}, says nothing");
    assert!(nominal::choose_order(&data, Some(&held)).is_some_and(|order| order >= 4));
}

#[test]
fn the_gradient_is_that_of_the_cost() {
    for operator in [Operator::hysteresis(-0.2), Operator::memoryless(0.3)] {
        let mut model = hysteretic(0.2);
        model.operator = operator;
        // A loop over the structure too, not over the drive alone.
        model.cz.iter_mut().enumerate().for_each(|(k, c)| *c = 0.03 * (k as f64 - 3.0));
        model.f.iter_mut().enumerate().for_each(|(k, f)| *f = 0.02 * k as f64);
        let mut numbers = Numbers(3);
        let drive: Vec<f64> = (0..800).map(|_| 0.3 * numbers.normal()).collect();
        let position: Vec<f64> = (0..800).map(|_| 0.1 * numbers.normal()).collect();
        let stretch = [Stretch { drive, position, periodic: false, skip: 0, weight: 1.0 }];
        let equations = sensitivity::normal_equations(&model, &stretch, &[]).unwrap();
        let at = model.parameters();
        for k in 0..at.len() {
            let cost = |step: f64| {
                let mut moved = at.clone();
                moved[k] += step;
                sensitivity::cost(&model.with(&moved), &stretch).unwrap()
            };
            let slope = (cost(1e-6) - cost(-1e-6)) / 4e-6;
            let scale = slope.abs().max(1e-3 * equations.cost);
            assert!(
                (equations.gradient[k] - slope).abs() < 2e-3 * scale,
                "{k}: {slope} {}",
                equations.gradient[k]
            );
        }
    }
}
