//! Made structures with known answers.

use std::ops::Range;

use fitter::plant::{Auto, Kind, Order, Plant, PlantFile};

use super::looped::{Looped, Stretch};
use super::modal::{Block, Modal};
use super::operator::Operator;
use super::plan::Plan;
use super::{file, nominal, sensitivity};
use crate::compare::Change;
use crate::compare::motion::compare;
use crate::dynamic::spectrum::Complex;
use crate::dynamic::{Case, DynamicOutcome, DynamicRecording, Options, diagnose};
use crate::verdict::Verdict;

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
    record_by(7, model, amplitudes, noise)
}

/// The same by another seed.
fn record_by(seed: u64, model: &Looped, amplitudes: &[f64], noise: f64) -> DynamicRecording {
    let mut numbers = Numbers(seed);
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
        further: Vec::new(),
        file: "made.csv".into(),
        sha256: String::new(),
        step_s: 1e-3,
        t_s: (0..period.len()).map(|k| k as f64 * 1e-3).collect(),
        drives: drives.into_iter().map(Into::into).collect(),
        positions: positions.into_iter().map(Into::into).collect(),
        runs,
        period: Some(period),
        amplitude: Some(amplitude.into()),
        command: None,
        bad_rows: Vec::new(),
        notes: Vec::new(),
    }
}

fn plant() -> PlantFile {
    let plant = Plant {
        kind: Kind::Linear,
        order: Some(Order::Auto(Auto::Auto)),
        position_unit: "um".into(),
        drive_unit: "V".into(),
        feedback: None,
        damping: None,
        stiffness: None,
        gain: None,
        hold: None,
    };
    PlantFile { plant, state_space: None, effects: vec![], equations: None }
}

fn answer(recording: &DynamicRecording, plant: &PlantFile) -> DynamicOutcome {
    let options = Options::default();
    diagnose(&Case {
        recording,
        plant,
        plant_file: "plant.toml",
        simulated: None,
        held_out: None,
        options: &options,
    })
    .unwrap()
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

/// What is said to have changed between recordings of two structures.
fn changed(then: &Looped, now: &Looped, amplitudes: &[f64]) -> Vec<Change> {
    let [then, now] = [record_by(7, then, amplitudes, 0.01), record_by(11, now, amplitudes, 0.01)];
    let (plant, options) = (plant(), Options::default());
    let case = Case {
        recording: &then,
        plant: &plant,
        plant_file: "plant.toml",
        simulated: None,
        held_out: None,
        options: &options,
    };
    compare(&case, &now).unwrap().changes
}

#[test]
fn of_two_recordings_what_moved_is_named_alone() {
    let then = Looped::plain(structure());
    assert!(changed(&then, &then, &[1.0]).is_empty());
    // 40 Hz become 40.1.
    let mut stiffer = then.clone();
    let [re, im] = stiffer.linear.blocks[0].parameters;
    let pole = (Complex::new(re, im).ln() * (40.1 / 40.0)).exp();
    stiffer.linear.blocks[0].parameters = [pole.re, pole.im];
    let [ref moved] = changed(&then, &stiffer, &[1.0])[..] else { panic!("one change") };
    let difference = moved.parameters[0].difference.unwrap();
    assert_eq!((moved.id.as_str(), moved.parameters[0].unit.as_str()), ("resonance_1", "Hz"));
    assert!((difference.ci95[0]..difference.ci95[1]).contains(&0.1), "{difference:?}");
    assert!(moved.held_out.as_ref().is_some_and(|held_out| held_out.gain.value > 0.0));
    // The second drive is a fiftieth weaker.
    let mut weaker = then.clone();
    weaker.linear.b.iter_mut().skip(1).step_by(2).for_each(|b| *b *= 0.98);
    let [ref moved] = changed(&then, &weaker, &[1.0])[..] else { panic!("one change") };
    let ratio = moved.parameters[0].difference.unwrap();
    assert_eq!(moved.id, "gain_2");
    assert!((ratio.ci95[0]..ratio.ci95[1]).contains(&0.98), "{ratio:?}");
}

/// Asserts that the hysteresis, which becomes one of 0.3, is the first of what changed.
fn hysteresis_changes_first(then: &Looped) {
    let all = changed(then, &hysteretic(0.3), &[0.1, 0.4, 1.0]);
    assert_eq!(all[0].id, file::ID, "{:?}", all.iter().map(|change| &change.id).collect::<Vec<_>>());
}

#[test]
fn of_two_recordings_a_hysteresis_that_grew_is_named() {
    hysteresis_changes_first(&hysteretic(0.2));
}

#[test]
fn of_two_recordings_a_hysteresis_that_came_is_named() {
    hysteresis_changes_first(&Looped::plain(structure()));
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
fn without_periods_the_structure_is_found_by_segments() {
    let truth = structure();
    let mut recording = record(&Looped::plain(truth.clone()), &[1.0], 0.01);
    recording.period = None;
    recording.amplitude = None;
    let outcome = answer(&recording, &plant());
    assert!(outcome.diagnosis.effects.is_empty(), "{:?}", outcome.diagnosis.effects);
    let left = outcome.diagnosis.fit.before.held_out_rms.unwrap();
    assert!(left < 0.03, "{left} beside a noise of 0.01");
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

#[test]
fn a_linear_structure_is_consistent() {
    let recording = record(&Looped::plain(structure()), &[0.5, 1.5], 0.02);
    let outcome = answer(&recording, &plant());
    assert_eq!(outcome.diagnosis.verdict, Verdict::Consistent);
    assert!(outcome.diagnosis.effects.is_empty() && outcome.diagnosis.locations.is_empty());
    assert!((outcome.diagnosis.noise_floor.value / 0.02 - 1.0).abs() < 0.05);
}

#[test]
fn hysteresis_is_named_and_its_file_simulates_the_same() {
    let recording = record(&hysteretic(0.4), &[0.15, 0.45], 0.001);
    let outcome = answer(&recording, &plant());
    let d = &outcome.diagnosis;
    assert_eq!(d.effects.first().map(|e| e.id.as_str()), Some(file::ID), "{:?}", d.verdict);
    assert!(d.effects[0].alternatives.is_empty(), "memory is told from none");
    let amplitude = d.locations.iter().find(|l| l.variable == "amplitude").expect("it grows with amplitude");
    assert!((amplitude.from, amplitude.to) == (0.15, 0.45) && amplitude.share > 0.5, "{}", amplitude.share);
    let (before, after) = (d.fit.before.held_out_rms.unwrap(), d.fit.after.held_out_rms.unwrap());
    assert!(after < 0.3 * before, "{before} → {after}");
    // The file gives the model back: the same recording against it is consistent.
    let text = outcome.plant.to_toml();
    let again = PlantFile::parse("made.plant.toml", &text).unwrap();
    let model = file::to_model(&again).unwrap();
    let y = super::diagnose::free_run(&model, &recording, &recording.runs[0]).unwrap();
    let apart = (0..PERIOD).map(|n| (y[2 * n] - outcome.own.after[0][n]).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart}");
    let page = crate::report::of_motion(&recording, &outcome, &Default::default());
    assert!(page.contains("Spectrum at amplitude") && page.contains("hysteresis of the actuator"));
}

#[test]
fn a_constant_is_named_beside_a_linear_structure() {
    let mut recording = record(&Looped::plain(structure()), &[0.5, 1.5], 0.02);
    recording.positions[1].iter_mut().for_each(|x| *x += 0.05);
    let outcome = answer(&recording, &plant());
    let d = &outcome.diagnosis;
    assert_eq!(d.verdict, Verdict::Explained);
    let ids: Vec<&str> = d.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(ids, [super::offset::ID]);
    assert_eq!(d.effects[0].alternatives, ["drive_offset"], "a plant that holds its position cannot tell");
    let [first, second] = &d.effects[0].parameters[..] else { panic!("an offset of either position") };
    assert!(first.ci95[0] < 0.0 && first.ci95[1] > 0.0, "{first:?}");
    assert!(second.ci95[0] < 0.05 && second.ci95[1] > 0.05, "{second:?}");
    let after = d.fit.after.held_out_rms.unwrap();
    assert!((after / 0.02 - 1.0).abs() < 0.05, "{after}");
    // Against its own file nothing is left to say.
    let again = PlantFile::parse("made.plant.toml", &outcome.plant.to_toml()).unwrap();
    let outcome = answer(&recording, &again);
    assert_eq!(outcome.diagnosis.verdict, Verdict::Consistent, "{:?}", outcome.diagnosis.effects);
}
