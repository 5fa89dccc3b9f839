//! Runs against solutions in closed form, and their sensitivities against differences.

use super::super::{MotionEffect, Plant};
use super::*;
use crate::equations::Input;
use crate::signal::Signal;
use fitter::plant::PlantFile;
use fitter::plant::equations::declared;
use physics::number::Dual;

const OSCILLATOR: &str = "[plant]\nkind = \"equations\"\n\
    states = { x = { unit = \"rad\", start = 1.0 }, v = { unit = \"rad/s\", start = 0.0 } }\noutput = { y = \"x\" }\n\
    [plant.equations]\nx = \"v\"\nv = \"-a * x\"\n[plant.parameters]\na = { unit = \"1/s^2\", value = 4.0 }\n";
const FRICTION: &str =
    "[[effect]]\nid = \"dry\"\nequation.v = \"-f * sign(v)\"\nf = { unit = \"rad/s^2\" }\n";

fn system() -> System {
    let file = PlantFile::parse("plant.toml", OSCILLATOR).unwrap();
    let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
    let texts = declared("mine.toml", FRICTION).unwrap();
    let effects: Vec<MotionEffect> =
        texts.iter().map(|text| plant.effect("mine.toml", text).unwrap()).collect();
    System::new(&plant, &effects.iter().collect::<Vec<_>>()).unwrap()
}

fn course(substeps: usize) -> Course<'static> {
    Course { signals: &[], sample_s: 0.05, rows: 261, start_s: 0.0, substeps, observer: None }
}

/// x″ = −4x − 0.3 sign x′: every half swing about ∓0.075 loses 0.15, until it sticks.
fn exact(t_s: f64) -> f64 {
    let (offset, half) = (0.075, std::f64::consts::PI / 2.0);
    let (mut from, mut side) = (1.0, 1.0);
    for swing in 0.. {
        let begun = f64::from(swing) * half;
        // It sticks where the spring is too weak.
        if f64::abs(from) <= offset {
            return from;
        }
        if t_s < begun + half {
            return side * offset + (from - side * offset) * (2.0 * (t_s - begun)).cos();
        }
        from = 2.0 * side * offset - from;
        side = -side;
    }
    f64::NAN
}

#[test]
fn dry_friction_takes_the_same_from_every_swing_and_holds_in_the_end() {
    for substeps in [1, 2, 4] {
        let outputs = system().outputs(&[4.0, 0.3], &[1.0, 0.0], &course(substeps)).unwrap();
        let largest = outputs.iter().enumerate().map(|(k, y)| (y - exact(0.05 * k as f64)).abs());
        let largest = largest.fold(0.0, f64::max);
        let expected = 2e-5 / (substeps as f64).powi(4);
        assert!(largest < expected, "{substeps}: {largest:e}, expected {expected:e}");
        assert_eq!(outputs[260], outputs[230], "it is held");
    }
}

/// A level that overflows into a wall: filled by a sine, it stops at 1.
const LEVEL: &str = "[plant]\nkind = \"equations\"\ninputs = { u = \"V\" }\n\
    states = { h = { unit = \"V\", start = 0.5 }, g = { unit = \"V\", start = 0.9 } }\noutput = { y = \"h + g\" }\n\
    [plant.equations]\nh = \"a * u - k * sqrt(h) - c * hinge(h, 1)\"\ng = \"k * sqrt(h) - a * g - c * hinge(g, 1)\"\n\
    [plant.parameters]\na = { unit = \"1/s\", value = 0.4 }\nc = { unit = \"1/s\", value = 40.0 }\n\
    k = { unit = \"V^0.5/s\", value = 0.4 }\n";

#[test]
fn a_wall_is_followed_in_shorter_steps_with_its_sensitivities() {
    let file = PlantFile::parse("level.toml", LEVEL).unwrap();
    let plant = Plant::of("level.toml", &file).unwrap().unwrap();
    let system = System::new(&plant, &[]).unwrap();
    let drive: Vec<f64> = (0..200).map(|k| 1.0 + 0.8 * (k as f64 / 9.0).sin()).collect();
    let signal =
        Signal::new(&drive, 0.0, 2.0, fitter::plant::Hold::ZeroOrder, crate::signal::Edge::Reflected);
    let signals: [&dyn Input; 1] = [&signal];
    let course =
        Course { signals: &signals, sample_s: 2.0, rows: 200, start_s: 0.0, substeps: 4, observer: None };
    let at = |c: f64, k: f64| system.outputs(&[0.4, c, k], &[0.5, 0.9], &course).unwrap();
    let numbers = [Dual::<2>::from_f64(0.4), Dual::variable(40.0, 0), Dual::variable(0.4, 1)];
    let start = [0.5, 0.9].map(Dual::<2>::from_f64);
    let mut slopes = Vec::new();
    system.run(&numbers, &start, &course, &mut |_, y: Dual<2>| slopes.push(y.slopes)).unwrap();
    let h = 1e-6;
    let [by_c, by_k] = [[at(40.0 + h, 0.4), at(40.0 - h, 0.4)], [at(40.0, 0.4 + h), at(40.0, 0.4 - h)]];
    for (k, [c, a]) in slopes.iter().enumerate() {
        let along = |both: &[Vec<f64>; 2]| (both[0][k] - both[1][k]) / (2.0 * h);
        let apart = [c - along(&by_c), a - along(&by_k)].map(f64::abs);
        // The largest derivatives are 2e-4 and 3.
        assert!(apart[0] < 1e-6 && apart[1] < 1e-4, "{k}: {apart:?}");
    }
    let fine = system.outputs(&[0.4, 40.0, 0.4], &[0.5, 0.9], &Course { substeps: 400, ..course });
    let coarse = at(40.0, 0.4);
    let apart = fine.unwrap().iter().zip(&coarse).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-4, "{apart:e}");
}

#[test]
fn sensitivities_hold_across_events() {
    let system = system();
    let at = |f: f64, x: f64| system.outputs(&[4.0, f], &[x, 0.0], &course(8)).unwrap();
    let numbers = [Dual::<2>::from_f64(4.0), Dual::variable(0.3, 0)];
    let mut slopes = Vec::new();
    let start = [Dual::variable(1.0, 1), Dual::from_f64(0.0)];
    system.run(&numbers, &start, &course(8), &mut |_, y: Dual<2>| slopes.push(y.slopes)).unwrap();
    let h = 1e-6;
    let [by_f, by_x] = [[at(0.3 + h, 1.0), at(0.3 - h, 1.0)], [at(0.3, 1.0 + h), at(0.3, 1.0 - h)]];
    for (k, [f, x]) in slopes.iter().enumerate() {
        let along = |both: &[Vec<f64>; 2]| (both[0][k] - both[1][k]) / (2.0 * h);
        assert!((f - along(&by_f)).abs() < 1e-4, "row {k} by friction: {f} {}", along(&by_f));
        assert!((x - along(&by_x)).abs() < 1e-4, "row {k} by start: {x} {}", along(&by_x));
    }
}

/// z′ = (x − z)/τ from 0 on is a lag that begins there.
#[test]
fn a_state_of_an_effects_own_does_what_a_lag_does() {
    let file = PlantFile::parse("plant.toml", OSCILLATOR).unwrap();
    let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
    let own = "equation.v = \"-k * z\"\nstates = { z = \"(x - z) / tau\" }\n";
    let lag = "equation.v = \"-k * lowpass(x, tau, 0)\"\n";
    let outputs = [own, lag].map(|adds| {
        let text = format!(
            "[[effect]]\nid = \"creep\"\n{adds}k = {{ unit = \"1/s^2\" }}\n\
             tau = {{ unit = \"s\", from = 0.1, to = 9 }}\n"
        );
        let texts = declared("mine.toml", &text).unwrap();
        let effect = plant.effect("mine.toml", &texts[0]).unwrap();
        let system = System::new(&plant, &[&effect]).unwrap();
        assert_eq!(system.states(), 3);
        system.outputs(&[4.0, 1.5, 0.7], &[1.0, 0.0], &course(2)).unwrap()
    });
    assert_eq!(outputs[0], outputs[1]);
    assert!((outputs[0][260] - exact(13.0)).abs() > 0.01, "it does something");
}

#[test]
fn half_the_step_is_more_accurate_by_the_order_of_the_rule() {
    let last = |substeps, rows: usize| {
        let course = Course { sample_s: 4.0 / (rows - 1) as f64, rows, ..course(substeps) };
        let outputs = system().outputs(&[4.0, 0.0], &[1.0, 0.0], &course).unwrap();
        (outputs[rows - 1] - 8.0_f64.cos()).abs()
    };
    for (substeps, order) in [(1, 4), (2, 6), (8, 8)] {
        let [once, twice] = [17, 33].map(|rows| last(substeps, rows));
        // The next order makes it more or less than 2^order.
        let ratio = (once / twice).log2();
        assert!(ratio > f64::from(order) - 0.5, "{substeps}: {once:e} {twice:e}");
    }
}

/// What a held input jumps over within |u|, a limit, or one within the other.
#[test]
fn a_held_input_that_jumps_across_a_switch_is_on_the_other_side_at_once() {
    let drive = [0.5, -2.0, 0.0, 3.0, -0.25, 1.5, 1.5];
    let signal =
        Signal::new(&drive, 0.0, 0.1, fitter::plant::Hold::ZeroOrder, crate::signal::Edge::Reflected);
    let signals: [&dyn Input; 1] = [&signal];
    let course = Course { signals: &signals, rows: 7, sample_s: 0.1, ..course(1) };
    type Rate = fn(f64) -> f64;
    let rates: [(&str, Rate); 4] = [
        ("abs(u)", f64::abs),
        ("max(min(u, 1), -1)", |u| u.clamp(-1.0, 1.0)),
        ("hinge(u, 0.75)", |u| (u - 0.75).max(0.0)),
        ("sign(abs(u) - 1)", |u| if u.abs() < 1.0 { -1.0 } else { 1.0 }),
    ];
    for (text, rate) in rates {
        let file = format!(
            "[plant]\nkind = \"equations\"\ninputs = {{ u = \"1\" }}\n\
             states = {{ x = {{ unit = \"1/s\", start = 0.0 }} }}\noutput = {{ y = \"x\" }}\n\
             [plant.equations]\nx = \"c * {text}\"\n[plant.parameters]\nc = {{ unit = \"1/s^2\", value = 1.0 }}\n"
        );
        let file = PlantFile::parse("plant.toml", &file).unwrap();
        let plant = Plant::of("plant.toml", &file).unwrap().unwrap();
        let outputs = System::new(&plant, &[]).unwrap().outputs(&[1.0], &[0.0], &course).unwrap();
        let mut exact = 0.0;
        for (k, output) in outputs.iter().enumerate() {
            assert!((output - exact).abs() < 1e-12, "{text}, row {k}: {output} instead of {exact}");
            exact += 0.1 * rate(drive[k]);
        }
    }
}
