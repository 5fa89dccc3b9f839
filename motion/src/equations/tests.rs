//! What remembers, in equations of motion, against solutions in closed form.

use fitter::plant::PlantFile;
use fitter::plant::equations::declared;
use physics::number::{Dual, Number};

use super::*;
use crate::signal::{Edge, Signal};

const SAMPLE_S: f64 = 0.1;
const ROWS: usize = 101;

/// A plant with one effect.
fn system(plant: &str, effect: &str) -> System {
    let file = PlantFile::parse("plant.toml", plant).unwrap();
    let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
    let texts = declared("mine.toml", &format!("[[effect]]\nid = \"own\"\n{effect}")).unwrap();
    let effect = plant.effect("mine.toml", &texts[0]).unwrap();
    System::new(&plant, &[&effect]).unwrap()
}

/// Time, output and its derivative by the last parameter at every row.
fn run(system: &System, values: [f64; 2], start: &[f64], input: Option<&dyn Input>) -> Vec<[f64; 3]> {
    let signals: Vec<&dyn Input> = input.into_iter().collect();
    let course = Course {
        signals: &signals,
        sample_s: SAMPLE_S,
        rows: ROWS,
        start_s: 0.0,
        substeps: 4,
        observer: None,
    };
    let numbers = [Dual::<1>::from_f64(values[0]), Dual::variable(values[1], 0)];
    let start: Vec<Dual<1>> = start.iter().map(|x| Dual::from_f64(*x)).collect();
    let mut rows = Vec::new();
    let mut visit = |k: usize, y: Dual<1>| rows.push([k as f64 * SAMPLE_S, y.value, y.slopes[0]]);
    system.run(&numbers, &start, &course, &mut visit).unwrap();
    rows
}

/// x′ = −a x + u(t − T) under a step at 2 s, held: x = (1 − e^(−a s))/a at s = t − 2 − T after it.
#[test]
fn a_delayed_step_comes_later_by_the_delay() {
    let plant = "[plant]\nkind = \"equations\"\ninputs = { u = \"V\" }\nstates = { x = { unit = \"V\", start = 0.0 } }\n\
                 output = { y = \"x\" }\n[plant.equations]\nx = \"-a * x + u * 1 [1/s]\"\n[plant.parameters]\n\
                 a = { unit = \"1/s\", value = 1.5 }\n";
    let effect = "input.u = \"delay(u, T) - u\"\nT = { unit = \"s\", from = 0.01, to = 2 }\n";
    let samples: Vec<f64> = (0..ROWS).map(|row| if row < 20 { 0.0 } else { 1.0 }).collect();
    let signal = Signal::new(&samples, 0.0, SAMPLE_S, Hold::ZeroOrder, Edge::Reflected);
    // Within a row, and over several.
    for delay in [0.033, 0.1, 0.27, 1.234] {
        for [t, x, slope] in run(&system(plant, effect), [1.5, delay], &[0.0], Some(&signal)) {
            let since = (t - 2.0 - delay).max(0.0);
            let (exact, by_delay) = ((1.0 - (-1.5 * since).exp()) / 1.5, -(-1.5 * since).exp());
            // 0.0375^5 of the rule, forty times over.
            assert!((x - exact).abs() < 1e-8, "{delay} {t}: {x} {exact}");
            // The derivative of the rule by its step is an order less: 0.0375^4/24.
            if since > 1e-9 {
                assert!((slope - by_delay).abs() < 1e-7, "{delay} {t}: {slope} {by_delay}");
            }
        }
    }
}

const OSCILLATOR: &str = "[plant]\nkind = \"equations\"\n\
    states = { x = { unit = \"m\", start = 1.0 }, v = { unit = \"m/s\", start = 0.0 } }\noutput = { y = \"x\" }\n\
    [plant.equations]\nx = \"v\"\nv = \"-a * x\"\n[plant.parameters]\na = { unit = \"1/s^2\", value = 4.0 }\n";

/// x = cos 2t across a gap of ±r: from the turn at 1 on it waits until x is below 1 − 2r, then follows by r above, waits at
/// −1 + r until x is above −1 + 2r, then follows by r below.
#[test]
fn a_play_turns_where_its_signal_turns() {
    let effect = "output.y = \"play(y, r, 1 [m] - r) - y\"\nr = { unit = \"m\", from = 0.01, to = 0.9 }\n";
    let gap = 0.3;
    for [t, y, slope] in run(&system(OSCILLATOR, effect), [4.0, gap], &[1.0, 0.0], None) {
        let x = (2.0 * t).cos();
        let falls = (2.0 * t).rem_euclid(std::f64::consts::TAU) < std::f64::consts::PI;
        let exact = if falls { (x + gap).min(1.0 - gap) } else { (x - gap).max(gap - 1.0) };
        let follows = if falls { x + gap < 1.0 - gap } else { x - gap > gap - 1.0 };
        let by_gap = if falls == follows { 1.0 } else { -1.0 };
        // The cubic through a turn, of a step of 0.05 radian.
        assert!((y - exact).abs() < 1e-5, "{t}: {y} {exact}");
        assert!((slope - by_gap).abs() < 1e-9, "{t}: {slope} {by_gap}");
    }
}

#[test]
fn the_rate_of_the_output_is_that_of_its_states() {
    let effect = "output.y = \"tau * rate(y)\"\ntau = { unit = \"s\" }\n";
    for [t, y, by_tau] in run(&system(OSCILLATOR, effect), [4.0, 0.25], &[1.0, 0.0], None) {
        let rate = -2.0 * (2.0 * t).sin();
        assert!((y - (2.0 * t).cos() - 0.25 * rate).abs() < 1e-4, "{t}: {y}");
        assert!((by_tau - rate).abs() < 1e-4, "{t}: {by_tau} {rate}");
    }
}

#[test]
fn what_has_no_past_is_refused() {
    let file = PlantFile::parse("plant.toml", OSCILLATOR).unwrap();
    let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
    let of_time = "T = { unit = \"s\", from = 0.1, to = 2 }\n";
    for (adds, expected) in [
        ("output.y = \"delay(y, T) - y\"\n", "of inputs alone"),
        ("equation.v = \"-rate(v) * T * 1 [1/s]\"\n", "an effect on the output alone"),
        ("output.y = \"play(y, x * T * 1 [1/s]) - y\"\n", "a gap that stays as it is"),
    ] {
        let texts = declared("mine.toml", &format!("[[effect]]\nid = \"own\"\n{adds}{of_time}")).unwrap();
        let effect = plant.effect("mine.toml", &texts[0]).unwrap();
        let error = System::new(&plant, &[&effect]).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
