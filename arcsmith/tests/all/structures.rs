//! Structures of many modes, simulated apart from the diagnosis: what is found in one recording, and what changed between two.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use diagnosis::Verdict;
use diagnosis::compare::{Change, motion::compare};
use diagnosis::dynamic::{Case, DynamicOutcome, DynamicRecording, Options, diagnose};
use fitter::plant::{Auto, Hold, Kind, Numbers, Order, Plant, PlantEffect, PlantFile, StateSpace};
use motion::Start;
use motion::linear::LinearModel;
use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// Samples of a period, at 1 kHz.
const PERIOD: usize = 1024;
/// Its lines, up to 200 Hz.
const LINES: usize = 205;
const HYSTERESIS: &str = "rayleigh_hysteresis";

/// Two modes of a structure with two drives and two positions.
fn structure([first_hz, second_hz]: [f64; 2]) -> LinearModel {
    let pole = |hz: f64, damping: f64| {
        let w = TAU * hz * 1e-3;
        let radius = (-damping * w).exp();
        [radius * w.cos(), radius * w.sin()]
    };
    let mut a = vec![vec![0.0; 4]; 4];
    for (k, [re, im]) in [pole(first_hz, 0.02), pole(second_hz, 0.03)].into_iter().enumerate() {
        a[2 * k][2 * k..2 * k + 2].copy_from_slice(&[re, im]);
        a[2 * k + 1][2 * k..2 * k + 2].copy_from_slice(&[-im, re]);
    }
    let space = StateSpace {
        sample_time_s: 1e-3,
        a,
        b: vec![vec![0.3, 0.1], vec![0.2, -0.1], vec![-0.2, 0.4], vec![0.1, 0.2]],
        c: vec![vec![1.0, 0.2, -0.5, 0.3], vec![0.4, 0.5, 0.9, -0.2]],
        d: vec![vec![0.0; 2]; 2],
    };
    LinearModel { space, effects: Vec::new(), hold: Hold::ZeroOrder }
}

fn plain() -> LinearModel {
    structure([40.0, 95.0])
}

/// The same with Rayleigh's hysteresis between drives and forces: a bank of plays of equal weight.
fn hysteretic(strength: f64) -> LinearModel {
    let linear = plain();
    let scaled =
        |rows: &[Vec<f64>]| Numbers::Each(rows.iter().flatten().map(|value| strength * value).collect());
    let parameters = [
        ("into_state", scaled(&linear.space.b)),
        ("into_position", scaled(&linear.space.d)),
        ("from_state", Numbers::Each(vec![0.0; 8])),
        ("from_drive", Numbers::Each(vec![1.0, 0.0, 0.0, 1.0])),
        ("thresholds", Numbers::Each((0..40).map(|k| 0.05 * (f64::from(k) + 0.5)).collect())),
        ("weights", Numbers::Each(vec![0.05; 40])),
    ];
    let parameters: BTreeMap<String, Numbers> = parameters.map(|(name, value)| (name.into(), value)).into();
    LinearModel { effects: vec![PlantEffect { id: HYSTERESIS.into(), parameters }], ..linear }
}

/// Four runs of two periods at each amplitude: multisines of random phases, white noise.
fn record(seed: u64, model: &LinearModel, amplitudes: &[f64], noise: f64) -> DynamicRecording {
    let mut numbers = ChaCha12Rng::seed_from_u64(seed);
    let (mut drives, mut positions) = (vec![vec![]; 2], vec![vec![]; 2]);
    let (mut runs, mut period, mut amplitude) = (Vec::new(), Vec::new(), Vec::new());
    for &size in amplitudes {
        for _ in 0..4 {
            let one = |numbers: &mut ChaCha12Rng| -> Vec<f64> {
                let phases: Vec<f64> = (0..LINES).map(|_| numbers.random_range(0.0..TAU)).collect();
                let at = |n: usize| {
                    let t = TAU * n as f64 / PERIOD as f64;
                    let lines =
                        phases.iter().enumerate().map(|(k, phase)| ((k + 1) as f64 * t + phase).cos());
                    size * lines.sum::<f64>() / (LINES as f64 / 2.0).sqrt()
                };
                (0..PERIOD).map(at).collect()
            };
            let drive = [one(&mut numbers), one(&mut numbers)];
            let steady = model.simulate(&drive, 1e-3, Start::Steady { period: PERIOD }).unwrap();
            let start = period.len();
            for turn in 0..2 {
                for k in 0..2 {
                    drives[k].extend_from_slice(&drive[k]);
                    // The sum of twelve is nearly normal, with a variance of one.
                    let mut normal = || (0..12).map(|_| numbers.random_range(0.0..1.0)).sum::<f64>() - 6.0;
                    positions[k].extend(steady[k].iter().map(|position| position + noise * normal()));
                }
                period.extend([turn; PERIOD]);
                amplitude.extend([size; PERIOD]);
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

fn nominal() -> PlantFile {
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

fn case<'a>(recording: &'a DynamicRecording, plant: &'a PlantFile, options: &'a Options) -> Case<'a> {
    Case { recording, plant, plant_file: "plant.toml", simulated: None, held_out: None, options }
}

fn answer(recording: &DynamicRecording, plant: &PlantFile) -> DynamicOutcome {
    diagnose(&case(recording, plant, &Options::default())).unwrap()
}

/// What is said to have changed between recordings of two structures.
fn changed(then: &LinearModel, now: &LinearModel, amplitudes: &[f64]) -> Vec<Change> {
    let [then, now] = [record(7, then, amplitudes, 0.01), record(11, now, amplitudes, 0.01)];
    compare(&case(&then, &nominal(), &Options::default()), &now).unwrap().changes
}

#[test]
fn what_moved_is_named_alone() {
    let then = plain();
    assert!(changed(&then, &then, &[1.0]).is_empty());
    let stiffer = structure([40.1, 95.0]);
    let [ref moved] = changed(&then, &stiffer, &[1.0])[..] else { panic!("one change") };
    let difference = moved.parameters[0].difference.unwrap();
    assert_eq!((moved.id.as_str(), moved.parameters[0].unit.as_str()), ("resonance_1", "Hz"));
    assert!((difference.ci95[0]..difference.ci95[1]).contains(&0.1), "{difference:?}");
    assert!(moved.held_out.as_ref().is_some_and(|held_out| held_out.gain.value > 0.0));
    // The second drive is a fiftieth weaker.
    let mut weaker = then.clone();
    weaker.space.b.iter_mut().for_each(|row| row[1] *= 0.98);
    let [ref moved] = changed(&then, &weaker, &[1.0])[..] else { panic!("one change") };
    let ratio = moved.parameters[0].difference.unwrap();
    assert_eq!(moved.id, "gain_2");
    assert!((ratio.ci95[0]..ratio.ci95[1]).contains(&0.98), "{ratio:?}");
}

#[test]
fn a_hysteresis_that_came_or_grew_is_the_first_of_what_changed() {
    for then in [plain(), hysteretic(0.2)] {
        let all = changed(&then, &hysteretic(0.3), &[0.2, 1.0]);
        let ids: Vec<&str> = all.iter().map(|change| change.id.as_str()).collect();
        assert_eq!(ids.first(), Some(&HYSTERESIS), "{ids:?}");
    }
}

#[test]
fn without_periods_the_structure_is_found_by_segments() {
    let mut recording = record(7, &plain(), &[1.0], 0.01);
    recording.period = None;
    recording.amplitude = None;
    let outcome = answer(&recording, &nominal());
    assert!(outcome.diagnosis.effects.is_empty(), "{:?}", outcome.diagnosis.effects);
    let left = outcome.diagnosis.fit.before.held_out_rms.unwrap();
    assert!(left < 0.03, "{left} beside a noise of 0.01");
}

#[test]
fn a_linear_structure_is_consistent() {
    let outcome = answer(&record(7, &plain(), &[0.5, 1.5], 0.02), &nominal());
    assert_eq!(outcome.diagnosis.verdict, Verdict::Consistent);
    assert!(outcome.diagnosis.effects.is_empty() && outcome.diagnosis.locations.is_empty());
    assert!((outcome.diagnosis.noise_floor.value / 0.02 - 1.0).abs() < 0.05);
}

#[test]
fn hysteresis_is_named_and_its_file_simulates_the_same() {
    let recording = record(7, &hysteretic(0.4), &[0.15, 0.45], 0.001);
    let outcome = answer(&recording, &nominal());
    let d = &outcome.diagnosis;
    assert_eq!(d.effects.first().map(|e| e.id.as_str()), Some(HYSTERESIS), "{:?}", d.verdict);
    assert!(d.effects[0].alternatives.is_empty(), "memory is told from none");
    let amplitude = d.locations.iter().find(|l| l.variable == "amplitude").expect("it grows with amplitude");
    assert!((amplitude.from, amplitude.to) == (0.15, 0.45) && amplitude.share > 0.5, "{}", amplitude.share);
    let (before, after) = (d.fit.before.held_out_rms.unwrap(), d.fit.after.held_out_rms.unwrap());
    assert!(after < 0.3 * before, "{before} → {after}");
    // The file simulates what the diagnosis predicts.
    let file = PlantFile::parse("made.plant.toml", &outcome.plant.to_toml()).unwrap();
    let model =
        LinearModel { space: file.state_space.unwrap(), effects: file.effects, hold: Hold::ZeroOrder };
    let drives = recording.drives.iter().map(|drive| drive[..PERIOD].to_vec()).collect::<Vec<_>>();
    let simulated = model.simulate(&drives, 1e-3, Start::Steady { period: PERIOD }).unwrap();
    let apart =
        simulated[0].iter().zip(&outcome.own.after[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart}");
    let page = diagnosis::report::of_motion(&recording, &outcome, &Default::default());
    assert!(page.contains("Spectrum at amplitude") && page.contains("hysteresis of the actuator"));
}

#[test]
fn a_constant_is_named_beside_a_linear_structure() {
    let mut recording = record(7, &plain(), &[0.5, 1.5], 0.02);
    recording.positions[1].iter_mut().for_each(|x| *x += 0.05);
    let outcome = answer(&recording, &nominal());
    let d = &outcome.diagnosis;
    assert_eq!(d.verdict, Verdict::Explained);
    let ids: Vec<&str> = d.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(ids, ["sensor_offset"]);
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
