//! Every method and format has a Gappa script that proves the certificate's rounding, and none that proves less.

use std::time::Instant;

use arcsmith_tests::toolchain::available;
use codegen::format::Format;
use codegen::gappa;
use codegen::options::{Method, Options, OutOfRange, RoutineOptions};
use codegen::output::Output;
use codegen::physics::Further;
use codegen::render::Renderer;
use codegen::routine;
use codegen::source::Source;
use codegen::verify::external::run_gappa;

/// Time for a script that must hold, and for one that must not: too tight a goal makes Gappa split on and on.
const SECONDS: u64 = 60;
const CONTROL_SECONDS: u64 = 2;

fn variants() -> Vec<RoutineOptions> {
    let table =
        |degree, segments_log2| Method::Piecewise { degree, segments_log2, padded: false, place: None };
    let fused = Format::ALL.into_iter().chain([Format::F32Fma]).map(RoutineOptions::of);
    let tables = [Format::Q31, Format::Q31Split].into_iter().flat_map(|format| {
        [table(1, 8), table(2, 5), table(3, 4), table(1, 12)]
            .map(|method| RoutineOptions { method, ..RoutineOptions::of(format) })
    });
    fused.chain(tables).collect()
}

#[test]
fn some_formats_are_proved_by_gappa() {
    are_proved(variants().into_iter().take(2));
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn every_format_and_table_is_proved_by_gappa() {
    are_proved(variants().into_iter());
}

fn are_proved(variants: impl Iterator<Item = RoutineOptions>) {
    if !available("gappa", "proofs by Gappa; apt-get install gappa") {
        return;
    }
    let renderer = Renderer::new().unwrap();
    let (coefficients, _) = Source::Embedded.load().unwrap();
    for wanted in variants {
        let options = Options {
            routines: vec![wanted.clone()],
            bound: Some(f64::MAX),
            degree: (wanted.method == Method::Fused).then_some(9),
            out_of_range: OutOfRange::Clamp,
            ..Options::default()
        };
        let routine =
            routine::design(&coefficients, &options, &wanted).unwrap_or_else(|e| panic!("{wanted:?}: {e}"));
        let text = gappa::script(&renderer, &routine, "routine", "").unwrap();
        let text = text.unwrap_or_else(|| panic!("{wanted:?}: no script"));
        let folder = tempfile::tempdir().unwrap();
        let script = folder.path().join("routine.g");
        std::fs::write(&script, &text).unwrap();
        let started = Instant::now();
        assert_eq!(run_gappa(&script, SECONDS).unwrap(), Some(Ok(())), "{wanted:?}");
        println!("{}: {:.2} s", wanted.suffix(), started.elapsed().as_secs_f64());

        // The control: nine tenths of the rounding, which in fixed point is nearly reached, is not proved.
        let bound = routine.design.bound.rounding;
        let (before, claim) = text.rsplit_once("<= ").unwrap();
        let after = claim.split_once('}').unwrap().1;
        let tight = folder.path().join("tight.g");
        std::fs::write(&tight, format!("{before}<= {} }}{after}", 0.9 * bound)).unwrap();
        assert_ne!(run_gappa(&tight, CONTROL_SECONDS).unwrap(), Some(Ok(())), "{wanted:?}");
    }
}

#[test]
fn a_play_is_proved_by_gappa() {
    terms_are_proved(1);
}

#[test]
#[ignore = "takes long: in .ci/full"]
fn terms_of_further_physics_are_proved_by_gappa() {
    terms_are_proved(usize::MAX);
}

/// With terms of further physics, so many kinds of them: the whole combination is proved, and neither a goal below it nor
/// a script in which a single product, sum, coefficient or given distance is another.
fn terms_are_proved(most: usize) {
    if !available("gappa", "proofs by Gappa; apt-get install gappa") {
        return;
    }
    let renderer = Renderer::new().unwrap();
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../codegen/tests/terms.coefficients.json");
    let coefficients = fitter::coefficients::read(&path).unwrap();
    let without = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
    let plays = without(&[
        "thermal_lag",
        "read_lag",
        "warmup_drift",
        "periodic_error",
        "local_defect",
        "sensor_clipping",
    ]);
    let shapes = without(&["hysteresis", "thermal_lag", "read_lag", "warmup_drift", "periodic_error"]);
    let times = without(&["hysteresis", "local_defect", "sensor_clipping", "periodic_error"]);
    let repeats = without(&[
        "hysteresis",
        "thermal_lag",
        "read_lag",
        "warmup_drift",
        "local_defect",
        "sensor_clipping",
    ]);
    let q31 = RoutineOptions::of(Format::Q31);
    for (what, leave_out, wanted) in [
        ("plays", &plays, q31.clone()),
        ("plays, from halves", &plays, RoutineOptions::of(Format::Q31Split)),
        ("plays, in nanoradians", &plays, RoutineOptions { output: Output::Nano, ..q31.clone() }),
        (
            "plays, beside a table",
            &plays,
            RoutineOptions {
                method: Method::Piecewise { degree: 2, segments_log2: 5, padded: false, place: None },
                ..q31.clone()
            },
        ),
        ("bumps and thresholds", &shapes, q31.clone()),
        ("what needs the time", &times, q31.clone()),
        (
            "what repeats, beside a table",
            &repeats,
            RoutineOptions {
                method: Method::Piecewise { degree: 2, segments_log2: 5, padded: false, place: None },
                ..q31.clone()
            },
        ),
        ("what repeats", &repeats, q31),
    ]
    .into_iter()
    .take(most)
    {
        let options = Options {
            routines: vec![wanted.clone()],
            bound: Some(f64::MAX),
            degree: (wanted.method == Method::Fused).then_some(9),
            without: leave_out.clone(),
            keep: if std::ptr::eq(leave_out, &times) { without(&["warmup_drift"]) } else { Vec::new() },
            further: vec![Further::parse("temperature_c=15..35:counts:12:0.01:400").unwrap()],
            period_s: Some(0.01),
            ..Options::default()
        };
        let routine =
            routine::design(&coefficients, &options, &wanted).unwrap_or_else(|e| panic!("{what}: {e}"));
        let text = gappa::script(&renderer, &routine, "routine", "").unwrap();
        let text = text.unwrap_or_else(|| panic!("{what}: no script"));
        let folder = tempfile::tempdir().unwrap();
        let proved = |text: &str, seconds: u64| {
            let script = folder.path().join("routine.g");
            std::fs::write(&script, text).unwrap();
            run_gappa(&script, seconds).unwrap() == Some(Ok(()))
        };
        let started = Instant::now();
        assert!(proved(&text, SECONDS), "{what}:\n{text}");
        println!("{what}: {:.2} s", started.elapsed().as_secs_f64());

        let (before, claim) = text.rsplit_once("<= ").unwrap();
        let after = claim.split_once('}').unwrap().1;
        let tight = format!("{before}<= {} }}{after}", 0.9 * routine.design.bound.rounding);
        assert!(!proved(&tight, CONTROL_SECONDS), "{what}: nine tenths");
        // Only what the routine computes is changed, or what is given of a word: never both.
        let damage = |of: &dyn Fn(&str) -> bool, to: &dyn Fn(&str) -> String| {
            let line = text.lines().rfind(|line| of(line)).unwrap_or_else(|| panic!("{what}"));
            text.replacen(line, &to(line), 1)
        };
        let product = damage(&|l| l.starts_with("r_") && l.contains("floor") && !l.contains("->"), &|l| {
            l.replacen(" + ", " + 300 + ", 1)
        });
        assert!(!proved(&product, CONTROL_SECONDS), "{what}: a sum that is another");
        let given = damage(&|l| l.trim_start().starts_with("g_") && l.contains(" in ["), &|l| {
            let (name, rest) = l.split_once(" in [").unwrap();
            format!("{name} in [-0x1p24, 0x1p24]{}", rest.split_once(']').unwrap().1)
        });
        assert!(!proved(&given, CONTROL_SECONDS), "{what}: a word further from exact");
    }
}
