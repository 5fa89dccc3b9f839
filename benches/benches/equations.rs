//! A second-order plant with four effects on 5000 rows: by its own simulation (`motion::Model`, plain numbers), and written
//! as equations, with the derivatives of the output by 8 parameters. Figure to hold: a ratio of at most 1.

use std::time::Instant;

use fitter::plant::equations::declared;
use fitter::plant::{Hold, PlantEffect, PlantFile};
use motion::equations::{Course, Input, MotionEffect, Plant, System};
use motion::model::Start;
use motion::{Context, Edge, Model, Signal};
use physics::number::{Dual, Number};

const ROWS: usize = 5000;
const SAMPLE_S: f64 = 1e-3;
/// Rounds of which the fastest counts.
const ROUNDS: usize = 15;
/// Largest difference from the plant's own simulation, over the largest position: what a diagnosis integrates to.
const ACCURATE: f64 = 1e-5;

const PLANT: &str = "[plant]\nkind = \"equations\"\ninputs = { u = \"A\" }\n\
    states = { x = { unit = \"rad\", start = 0.0 }, v = { unit = \"rad/s\", start = 0.0 } }\noutput = { y = \"x\" }\n\
    [plant.equations]\nx = \"v\"\nv = \"-d * v - k * x + g * u\"\n[plant.parameters]\n\
    d = { unit = \"1/s\", value = 12.0 }\nk = { unit = \"1/s^2\", value = 15000.0 }\n\
    g = { unit = \"rad/(s^2 A)\", value = 15000.0 }\n";
const EFFECTS: &str = "[[effect]]\nid = \"cubic\"\nequation.v = \"-c * x^3\"\nc = { unit = \"1/(rad^2 s^2)\" }\n\
    [[effect]]\nid = \"film\"\nequation.v = \"-n * x^2 * v\"\nn = { unit = \"1/(rad^2 s)\" }\n\
    [[effect]]\nid = \"drag\"\nequation.v = \"-q * v * abs(v)\"\nq = { unit = \"1/rad\" }\n";
const LAG: &str = "[[effect]]\nid = \"lag\"\ninput.u = \"lowpass(u, tau) - u\"\n\
    tau = { unit = \"s\", from = 1e-4, to = 0.1 }\n";
const DRY: &str = "[[effect]]\nid = \"dry\"\nequation.v = \"-f * sign(v)\"\nf = { unit = \"rad/s^2\" }\n";

/// A multisine around the resonance.
fn drive() -> Vec<f64> {
    let one = |row: usize| {
        let tone = |k: usize| (k as f64 * 12.3 * row as f64 * SAMPLE_S + (k * k) as f64).sin();
        0.2 * (1..16).map(tone).sum::<f64>()
    };
    (0..ROWS).map(one).collect()
}

/// The plant's own simulation.
fn second_order(last: PlantEffect) -> Model {
    let one = |id, name, value| PlantEffect::new(id, &[(name, value)]);
    let effects = vec![
        one("cubic_stiffness", "coefficient", 4000.0),
        one("nonlinear_damping", "coefficient", 3.0),
        one("quadratic_damping", "coefficient", 0.05),
        last,
    ];
    let context = Context { feedback: false };
    let (damping, stiffness, gains, hold) = (12.0, 15000.0, vec![15000.0], Hold::ZeroOrder);
    Model { damping, stiffness, gains, effects, hold, context }.check().expect("all effects are known")
}

/// The same as equations.
fn in_equations(last: &str) -> System {
    let file = PlantFile::parse("plant.toml", PLANT).expect("the plant is right");
    let plant = Plant::of("plant.toml", &file).expect("in equations").expect("the plant is right");
    let texts = declared("effects.toml", &format!("{EFFECTS}{last}")).expect("the effects are right");
    let effects: Vec<MotionEffect> =
        texts.iter().map(|text| plant.effect("effects.toml", text).expect("the effect is right")).collect();
    System::new(&plant, &effects.iter().collect::<Vec<_>>()).expect("all can be computed")
}

/// Seconds of the fastest round of each, which take turns.
fn seconds<const N: usize>(runs: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut fastest = [f64::INFINITY; N];
    let mut runs = runs;
    for _ in 0..ROUNDS {
        for (run, fastest) in runs.iter_mut().zip(&mut fastest) {
            let start = Instant::now();
            run();
            *fastest = fastest.min(start.elapsed().as_secs_f64());
        }
    }
    fastest
}

fn compare(name: &str, own: &Model, system: &System, last: f64) {
    let drive = drive();
    let signal = Signal::new(&drive, 0.0, SAMPLE_S, Hold::ZeroOrder, Edge::Reflected);
    let signals: [&dyn Input; 1] = [&signal];
    let course = |substeps| Course {
        signals: &signals,
        sample_s: SAMPLE_S,
        rows: ROWS,
        start_s: 0.0,
        substeps,
        observer: None,
    };
    let start = Start::At { position: 0.1, velocity: 0.0 };
    let run_own = || own.simulate(std::slice::from_ref(&drive), SAMPLE_S, start).expect("it moves");
    let values = [12.0, 15000.0, 15000.0, 4000.0, 3.0, 0.05, last];
    let expected = run_own();
    let size = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let apart = |substeps: &usize| {
        let outputs = system.outputs(&values, &[0.1, 0.0], &course(*substeps)).expect("it moves");
        outputs.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let substeps =
        [1, 2, 4, 8].into_iter().find(|k| apart(k) < ACCURATE * size).expect("they are the same plant");
    let numbers: Vec<Dual<8>> =
        values.iter().enumerate().map(|(k, value)| Dual::variable(*value, k)).collect();
    let begin = [Dual::variable(0.1, 7), Dual::from_f64(0.0)];
    let mut sum = 0.0;
    let mut with_derivatives = || {
        let mut visit = |_, y: Dual<8>| sum += y.slopes[0];
        system.run(&numbers, &begin, &course(substeps), &mut visit).expect("it moves");
    };
    let mut plain = || _ = system.outputs(&values, &[0.1, 0.0], &course(substeps)).expect("it moves");
    let mut run_own = || _ = run_own();
    let [own, plain, equations] = seconds([&mut run_own, &mut plain, &mut with_derivatives]);
    println!(
        "{name}: second order {:.0} ns per row; equations (as {substeps} classical steps per row) {:.0} ns, with 8 derivatives {:.0} ns; \
         ratio {:.2}",
        1e9 * own / ROWS as f64,
        1e9 * plain / ROWS as f64,
        1e9 * equations / ROWS as f64,
        equations / own
    );
    assert!(sum.is_finite());
}

fn main() {
    let lag = PlantEffect::new("drive_lag", &[("time_constant_s", 2e-3)]);
    compare("with a lag of the drive", &second_order(lag), &in_equations(LAG), 2e-3);
    let dry = PlantEffect::new("coulomb_friction", &[("force_per_inertia", 200.0)]);
    compare("with dry friction", &second_order(dry), &in_equations(DRY), 200.0);
}
