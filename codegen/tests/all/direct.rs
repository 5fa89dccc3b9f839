//! Direct sensors in their own units: what is asked for where nothing is named, and what a file of many terms gives.

use codegen::format::Format;
use codegen::generate::{GenerateError, generate};
use codegen::interpret::{Word, interpret};
use codegen::options::{Ends, Method, Options};
use codegen::program::Op;
use codegen::routine::{self, Routine, RoutineError};
use fitter::coefficients::{Coefficients, Diagnosed};
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Operator, Periodic, Play, Product, Rate, Scope, Term};

/// A sensor in `unit` with an error of this polynomial about the middle of its range, and this noise.
fn sensor(unit: &str, (from, to): (f64, f64), coefficients: Vec<f64>, noise: f64) -> Coefficients {
    let sensor = Sensor::Direct { unit: unit.into(), revolution: None };
    let model = ErrorModel { sensor, centre: 0.5 * (from + to), coefficients };
    let mut file = Coefficients::of_model(&model, from, to, "by hand");
    file.diagnosis = Some(Diagnosed {
        verdict: "explained".into(),
        before_rms: 10.0 * noise,
        after_rms: noise,
        noise_floor: noise,
    });
    file
}

fn term(effect: &str, operator: Operator, coefficients: Vec<f64>) -> Term {
    Term { effect: effect.into(), scope: Scope::Device, operator, coefficients, covariance: Vec::new() }
}

fn q31() -> Options {
    Options { routines: vec![Ends::default().routine(Method::Fused, Format::Q31)], ..Options::default() }
}

fn designed(file: &Coefficients, options: &Options) -> Routine {
    routine::design(file, options, &options.routines[0]).unwrap()
}

/// Words all over the valid range.
fn words(routine: &Routine, count: i64) -> impl Iterator<Item = i64> {
    let Op::Clamp { lo, hi, .. } = routine.design.program.steps[routine.design.program.clamped].op else {
        panic!("the range is limited")
    };
    (0..=count).map(move |i| lo + (hi - lo) / count * i)
}

#[test]
fn the_default_bound_is_small_beside_the_noise() {
    for (unit, range, noise) in
        [("mm", (1.0, 12.0), 3e-4), ("deg", (-22.5, -17.0), 1e-3), ("um", (0.0, 900.0), 0.2)]
    {
        let routine = designed(&sensor(unit, range, vec![0.01, 1e-3, -1e-5], noise), &q31());
        assert!(routine.design.bound.total <= 0.01 * noise, "{unit}: {:?}", routine.design.bound);
    }
    // Words of 32 bits over 360 degrees do not reach a hundredth of this noise, and reach a tenth.
    let fine = |noise| sensor("deg", (0.0, 360.0), vec![0.01, 1e-3, -1e-5], noise);
    let coarse = designed(&fine(1e-5), &q31()).design.bound.total;
    assert!(coarse > 1e-7 && coarse <= 1e-6, "{coarse}");
    // What is offered instead can be had.
    let refused = routine::design(&fine(1e-8), &q31(), &q31().routines[0]).unwrap_err().to_string();
    let offered = refused.split_once("the best is ").and_then(|(_, best)| best.split_once(" deg "));
    let offered: f64 = offered.unwrap_or_else(|| panic!("{refused}")).0.parse().unwrap();
    assert!(offered <= coarse, "{offered}");
    let bounded = Options { bound: Some(offered), ..q31() };
    assert!(designed(&fine(1e-8), &bounded).design.bound.total <= offered);
    // A bound that is named is kept.
    let named = Options { bound: Some(1e-7), ..q31() };
    assert!(matches!(
        routine::design(&fine(1e-5), &named, &named.routines[0]),
        Err(RoutineError::Unreachable { .. })
    ));
}

/// f32 holds 24 bits: over 360 degrees it is too coarse for a good encoder, which is no reason to refuse q31.
#[test]
fn a_usual_format_that_does_not_reach_the_bound_is_left_out() {
    let file = sensor("deg", (0.0, 360.0), vec![0.01, 1e-3], 1e-5);
    let usual = Options { leave_out_unreachable: true, ..Options::default() };
    let generated = generate(&file, "", &usual).unwrap();
    assert_eq!(generated.routines.len(), 1);
    assert!(generated.unreachable[0].to_string().contains("no f32 routine"), "{:?}", generated.unreachable);
    assert!(matches!(generate(&file, "", &Options::default()), Err(GenerateError::Routine(_))));
}

/// The Chebyshev polynomial of this order: one whose powers cancel each other.
fn chebyshev(order: usize) -> Vec<f64> {
    let (mut before, mut now) = (vec![1.0], vec![0.0, 1.0]);
    for _ in 1..order {
        let mut next = vec![0.0; now.len() + 1];
        now.iter().enumerate().for_each(|(k, c)| next[k + 1] += 2.0 * c);
        before.iter().enumerate().for_each(|(k, c)| next[k] -= c);
        before = std::mem::replace(&mut now, next);
    }
    now
}

/// Where the powers of one polynomial are too large for words, a table of short ones takes its place.
#[test]
fn a_high_order_in_a_narrow_range_gets_a_table() {
    let (range, half, noise) = ((9.977, 10.246), 0.1345, 0.01);
    let powers =
        chebyshev(15).iter().enumerate().map(|(k, c)| 0.02 * c / f64::powi(half, k as i32)).collect();
    let file = sensor("deg", range, powers, noise);
    let routine = designed(&file, &q31());
    assert!(matches!(routine.options.method, Method::Piecewise { .. }), "{:?}", routine.options);
    let (unit, bound, model) = (routine.design.unit.to_f64(), routine.design.bound.total, file.error_model());
    assert!(bound <= 0.01 * noise);
    for word in words(&routine, 2000) {
        let found = interpret(&routine.design.program, &[Word::Int(word)]).unwrap().word.bits() as f64 * unit;
        let expected = model.corrected(word as f64 * 16.0 / 2f64.powi(31));
        assert!((found - expected).abs() <= bound + 1e-9, "{word}: {found} {expected} {bound}");
    }
}

/// Two periods that have no turn in common, solved together within the bound.
#[test]
fn harmonics_of_several_periods_are_solved_together() {
    let mut file = sensor("mm", (-22.5, -19.0), vec![0.01, 1e-3], 1e-3);
    let (fine, coarse) = (Periodic::of(0.2513, 2), Periodic { period: 1.0007, harmonics: vec![1, 3] });
    let (a, b) = (vec![4e-3, 3e-3, -1e-3, 5e-4], vec![2e-3, -1e-3, 0.0, 4e-4]);
    file.terms = vec![
        term("periodic_error", Operator::Periodic(fine.clone()), a.clone()),
        term("screw", Operator::Periodic(coarse.clone()), b.clone()),
    ];
    let routine = designed(&file, &q31());
    let (unit, bound, model) = (routine.design.unit.to_f64(), routine.design.bound.total, file.error_model());
    assert!(bound <= 1e-5, "{bound}");
    let mut largest = 0.0f64;
    for word in words(&routine, 4000) {
        let observed = model.corrected(word as f64 * 32.0 / 2f64.powi(31));
        let mut truth = observed;
        for _ in 0..100 {
            let ((v, s), (w, t)) = (fine.value_and_slope(&a, truth), coarse.value_and_slope(&b, truth));
            truth -= (truth + v + w - observed) / (1.0 + s + t);
        }
        let found = interpret(&routine.design.program, &[Word::Int(word)]).unwrap().word.bits() as f64 * unit;
        largest = largest.max((found - truth).abs());
    }
    assert!(largest <= bound && largest > 0.05 * bound, "{largest} of {bound}");
}

/// What is too small to be evaluated leaves arguments that nobody reads: both languages compile without a warning.
#[test]
fn terms_that_vanish_leave_sources_without_warnings() {
    let further = codegen::physics::Further::parse("temperature_c=15..25").unwrap();
    let vanishing: [(&str, Operator, bool); 4] = [
        ("drift", Operator::Product(Product::of("temperature_c", 20.0)), true),
        ("lag", Operator::Rate(Rate::of("measured")), false),
        ("play", Operator::Play(Play::of("measured", &[1e-3])), false),
        ("narrow", Operator::Play(Play::of("measured", &[1e-13])), false),
    ];
    for (name, operator, of_temperature) in vanishing {
        let mut file = sensor("mm", (1.0, 12.0), vec![0.01, 1e-3], 1e-3);
        file.terms = vec![term(name, operator, vec![if name == "narrow" { 1.0 } else { 1e-13 }])];
        let further = if of_temperature { vec![further.clone()] } else { Vec::new() };
        let generated = generate(&file, "", &Options { further, period_s: Some(0.5), ..q31() }).unwrap();
        let folder = tempfile::tempdir().unwrap();
        codegen::files::write(folder.path(), &generated.files).unwrap();
        let c = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-c", "c/corrected_mm.c", "-o", "c.o"];
        let rust = ["--edition=2021", "--crate-type=lib", "-Dwarnings", "src/lib.rs", "-o", "rust.rlib"];
        for (compiler, arguments) in [("cc", &c[..]), ("rustc", &rust[..])] {
            let mut command = std::process::Command::new(compiler);
            let built = command.args(arguments).current_dir(folder.path()).output().unwrap();
            assert!(built.status.success(), "{name}: {}", String::from_utf8_lossy(&built.stderr));
        }
    }
}

/// The head never says less than the recording showed.
#[test]
fn the_uncertainty_is_above_what_the_recording_showed() {
    let (recording, mirror) = fitter::default_recording().unwrap();
    for order in [1, 2, 4, 9] {
        let options = fitter::Options { order: Some(order), ..fitter::Options::default() };
        let file = fitter::fit(&recording, &mirror, &options).unwrap().coefficients;
        let worst = file.statistics.as_ref().unwrap().after.max_of_point_means;
        let generated = generate(&file, "", &q31()).unwrap();
        let [low, high] = generated.certificate.budgets[0].budget.expanded();
        assert!(high >= worst && high > file.statistics.as_ref().unwrap().after.rms, "{order}: {high}");
        let head = &generated.files[std::path::Path::new("c/corrected_angle.h")];
        let said = [low, high].map(codegen::text::rounded_up);
        assert!(head.contains(&format!("U = {} … {} arcsec", said[0], said[1])), "{head}");
        assert!(!head.contains("Estimate"), "{head}");
    }
}
