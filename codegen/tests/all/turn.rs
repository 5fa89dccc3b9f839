//! Routines of encoders: every count of the compiled C and Rust against the fitter's own solution, whose arithmetic
//! is not the generator's.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use codegen::cost::Core;
use codegen::files;
use codegen::generate::{GenerateError, Generated, generate};
use codegen::options::Options;
use codegen::turn::{Encoder, TurnError, verify};
use fitter::coefficients::{Coefficients, Diagnosed};
use fitter::terms::{Operator, Periodic, Play, Product, Rate, Scope, Term};
use proptest::prelude::*;

#[path = "turn/encoder.rs"]
pub mod fixtures;
use fixtures::encoder;

/// Eccentric by 0.4°, with smaller harmonics.
fn usual() -> Coefficients {
    encoder(360.0, 137.3, &[0.3, 0.25, -0.1, 0.05, 0.0, 0.0, 0.02, -0.03])
}

fn options(encoder: Encoder) -> Options {
    Options { encoder, ..Options::default() }
}

/// The largest distance of the results of all counts from the fitter's solution, in counts of the result.
fn worst(file: &Coefficients, results: &[u32], counts: u32, result_counts: u32) -> f64 {
    let revolution = file.turn.as_ref().unwrap().revolution;
    let turn = f64::from(result_counts);
    (0..counts)
        .map(|count| {
            let reading = f64::from(count) * revolution / f64::from(counts);
            let exact = fitter::turn::corrected(file, reading).unwrap() / revolution * turn;
            assert!(results[count as usize] < result_counts);
            let off = f64::from(results[count as usize]) - exact;
            (off - turn * (off / turn).round()).abs()
        })
        .fold(0.0, f64::max)
}

/// The results of the interpreter's program for all words, by the compiled C and Rust.
fn swept(generated: &Generated, file: &Coefficients, options: &Options) -> verify::TurnReport {
    let folder = tempfile::tempdir().unwrap();
    files::write(folder.path(), &generated.files).unwrap();
    verify::verify(folder.path(), generated, file, options).unwrap()
}

/// Compiles the C with a program that prints the result of every count.
fn compiled(generated: &Generated, counts: u32) -> Vec<u32> {
    let folder = tempfile::tempdir().unwrap();
    let mut all: BTreeMap<PathBuf, String> = generated.files.clone();
    let main = "#include <stdio.h>\n#include \"corrected_counts.h\"\nint main(void) { for (uint32_t c = 0; c < COUNTS; ++c) \
                { printf(\"%lu\\n\", (unsigned long)corrected_counts(c)); } return 0; }\n";
    all.insert("c/main.c".into(), main.into());
    files::write(folder.path(), &all).unwrap();
    let c = folder.path().join("c");
    let built = Command::new("cc")
        .args([
            "-std=c99",
            "-O2",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-fsanitize=undefined",
            "-fno-sanitize-recover=all",
        ])
        .args([&format!("-DCOUNTS={counts}u"), "main.c", "corrected_counts.c", "-o", "sweep"])
        .current_dir(&c)
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let run = Command::new(c.join("sweep")).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8_lossy(&run.stdout).lines().map(|line| line.parse().unwrap()).collect()
}

/// Every width, core and flash that changes the form: bound, compiled results and certificate agree.
#[test]
fn every_count_is_within_the_bound() {
    let file = usual();
    for (bits, output_bits, core, flash_bytes) in [
        (10, None, Core::CortexM0, None),
        (12, Some(16), Core::CortexM4f, Some(400)),
        (14, None, Core::CortexM4f, None),
        (14, None, Core::CortexM3, Some(100_000)),
        (16, None, Core::CortexM0, None),
        (18, None, Core::CortexM4f, Some(4096)),
    ] {
        let wanted =
            Encoder { bits: Some(bits), output_bits, core: Some(core), flash_bytes, ..Encoder::default() };
        let options = options(wanted);
        let generated = generate(&file, "", &options).unwrap();
        let entry = &generated.certificate.routines[0];
        let output = output_bits.unwrap_or(bits);
        let lsb = 360.0 / 2f64.powi(output as i32);
        assert!(entry.bound <= 0.55 * lsb, "{bits} bits: {} of {lsb}", entry.bound);
        let results = compiled(&generated, 1 << bits);
        let found = worst(&file, &results, 1 << bits, 1 << output) * lsb;
        assert!(found <= entry.bound * (1.0 + 1e-9), "{bits} bits: {found} > {}", entry.bound);
        // Nothing is given away: the bound is what the worst count has.
        assert!(found >= entry.bound * (1.0 - 1e-6), "{bits} bits: {found} < {}", entry.bound);
        let report = swept(&generated, &file, &options);
        assert!(report.holds(), "{}", report.text());
        assert_eq!(report.sweeps.len(), 2);
        assert!(report.sweeps.iter().all(|s| s.words >= 1 << bits));
    }
}

/// Turns that are no power of two: line encoders, tenths of a degree, a few counts more than a power. The sum wraps at
/// both ends, for the zero lies close to one of them.
#[test]
fn turns_of_any_number_of_counts() {
    for (counts, finer, zero, core, flash_bytes) in [
        (4000, 0, 1.7, Core::CortexM4f, None),
        (4000, 2, 3998.2, Core::CortexM0, Some(100_000)),
        (10_000, 0, -2.3, Core::CortexM4f, None),
        (3600, 1, 1800.4, Core::CortexM0, None),
        (3600, 0, 0.1, Core::CortexM3, Some(100_000)),
        (16_385, 0, 8000.0, Core::CortexM4f, None),
        (257, 3, 0.0, Core::CortexM0, None),
        (100_000, 0, 99_999.6, Core::CortexM4f, Some(8192)),
    ] {
        let turn = f64::from(counts);
        let waves = [0.0011, 0.0007, -0.0003, 0.0002, 0.0, 0.0001].map(|w| w * turn);
        let file = encoder(turn, zero, &waves);
        let words = codegen::turn::shape::Words { counts, finer };
        let wanted = Encoder {
            output_bits: Some(words.output()),
            core: Some(core),
            flash_bytes,
            ..Encoder::default()
        };
        let options = options(wanted);
        let generated = generate(&file, "", &options).unwrap_or_else(|e| panic!("{counts}: {e}"));
        let entry = &generated.certificate.routines[0];
        let lsb = 0.5f64.powi(finer as i32);
        assert!(entry.bound <= 0.55 * lsb, "{counts}: {} of {lsb}", entry.bound);
        let results = compiled(&generated, counts);
        let found = worst(&file, &results, counts, counts << finer) * lsb;
        assert!(found <= entry.bound * (1.0 + 1e-9), "{counts}: {found} > {}", entry.bound);
        assert!(found >= entry.bound * (1.0 - 1e-6), "{counts}: {found} < {}", entry.bound);
        // Round the whole turn and over its end, one step of the result after the other.
        let turned: Vec<u32> = (0..counts).map(|c| results[c as usize]).collect();
        assert!(turned.windows(2).any(|w| w[1] < w[0]) || zero.rem_euclid(turn) < 10.0, "it wraps somewhere");
        let report = swept(&generated, &file, &options);
        assert!(report.holds(), "{}", report.text());
        // Words beyond the turn are given as well.
        assert!(report.sweeps.iter().all(|s| s.words > counts.into()));
    }
    // The number of counts may also be said, where the recording is in another unit.
    let options = options(Encoder { counts: Some(4000), ..Encoder::default() });
    let generated = generate(&usual(), "", &options).unwrap();
    let results = compiled(&generated, 4000);
    let found = worst(&usual(), &results, 4000, 4000) * 360.0 / 4000.0;
    assert!(found <= generated.certificate.routines[0].bound * (1.0 + 1e-9));
}

/// A damaged table, and a damaged certificate, are found.
#[test]
fn damage_is_found() {
    let file = usual();
    let options = options(Encoder { bits: Some(12), ..Encoder::default() });
    let generated = generate(&file, "", &options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    files::write(folder.path(), &generated.files).unwrap();
    let path = folder.path().join("c/corrected_counts.c");
    let text = std::fs::read_to_string(&path).unwrap();
    let row = text.lines().find(|line| line.starts_with("    { ") && line.contains(',')).unwrap();
    let first: i64 = row.trim_start_matches("    { ").split(',').next().unwrap().parse().unwrap();
    let damaged = row.replacen(&first.to_string(), &(first + 300).to_string(), 1);
    std::fs::write(&path, text.replacen(row, &damaged, 1)).unwrap();
    let report = verify::verify(folder.path(), &generated, &file, &options).unwrap();
    assert!(!report.holds() && !report.certificate.is_empty());
    assert!(report.sweeps.iter().any(|s| s.language == "c" && s.different > 0 && s.worst > s.bound));
    assert!(report.sweeps.iter().any(|s| s.language == "rust" && s.different == 0));
}

#[test]
fn what_cannot_be_generated_is_said() {
    let error = |file: &Coefficients, wanted: Encoder, bound: Option<f64>| {
        let options = Options { bound, ..options(wanted) };
        match generate(file, "", &options) {
            Err(GenerateError::Turn(error)) => error,
            other => panic!("{other:?}"),
        }
    };
    let bits = |bits: u32| Encoder { bits: Some(bits), ..Encoder::default() };
    let none = Encoder::default();
    assert!(matches!(error(&usual(), none, None), TurnError::UnknownBits { .. }));
    assert!(matches!(error(&usual(), bits(9), None), TurnError::Bits { bits: 9 }));
    assert!(matches!(error(&usual(), bits(14), Some(0.01)), TurnError::Bound { .. }));
    let coarse = Encoder { output_bits: Some(12), ..bits(14) };
    assert!(matches!(error(&usual(), coarse, None), TurnError::OutputBits { .. }));
    let small = Encoder { flash_bytes: Some(40), ..bits(14) };
    assert!(matches!(error(&usual(), small, None), TurnError::Nothing { .. }));
    for turn in [10_000.5, 100.0, 300_000.0] {
        let lines = encoder(turn, 3.0, &[0.001 * turn, 0.0]);
        assert!(matches!(error(&lines, none, None), TurnError::Counts { .. }));
    }
    let other = Encoder { counts: Some(4000), ..none };
    let lines = encoder(10_000.0, 3.0, &[20.0, 0.0]);
    assert!(matches!(error(&lines, other, None), TurnError::Contradiction { .. }));
    assert!(matches!(error(&usual(), Encoder { bits: Some(12), ..other }, None), TurnError::BitsAndCounts));
    let counts = encoder(16384.0, 3.0, &[20.0, 0.0]);
    assert!(matches!(error(&counts, bits(12), None), TurnError::Contradiction { .. }));
}

/// Terms that do not repeat with the turn, beside those of [`usual`].
fn with_more() -> Coefficients {
    let term = |effect: &str, scope, operator, coefficient: f64| Term {
        effect: effect.into(),
        scope,
        operator,
        coefficients: vec![coefficient],
        covariance: Vec::new(),
    };
    let mut file = usual();
    let product = |name: &str, mean| Operator::Product(Product::of(name, mean));
    file.terms.extend([
        term("turn_slope", Scope::Device, product("measured", 180.0), -0.0025),
        term("read_lag", Scope::Device, Operator::Rate(Rate::of("measured")), -0.034),
        term("backlash", Scope::Device, Operator::Play(Play::of("measured", &[0.011])), 1.0),
        term("thermal_zero_drift", Scope::Device, product("temperature_c", 21.0), 0.01),
        term("time_drift", Scope::Recording, product("t_s", 0.0), 1e-5),
    ]);
    let other = Operator::Periodic(Periodic { period: 17.3, harmonics: vec![1] });
    file.terms.push(Term { coefficients: vec![0.03, 0.04], ..term("gear", Scope::Device, other, 0.0) });
    file.observed.insert("temperature_c".into(), [15.0, 25.0]);
    file.turn.as_mut().unwrap().directions.speed_per_s = Some([5.0, 20.0]);
    file
}

/// What wraps is corrected as if the rest were not there; the rest is named with its largest value.
#[test]
fn what_does_not_repeat_with_the_turn_is_left_out_by_name_and_size() {
    let options = options(Encoder { bits: Some(12), ..Encoder::default() });
    let file = with_more();
    let generated = generate(&file, "", &options).unwrap();
    let entry = &generated.certificate.routines[0];
    let results = compiled(&generated, 4096);
    let found = worst(&usual(), &results, 4096, 4096) * 360.0 / 4096.0;
    assert!(found <= entry.bound * (1.0 + 1e-9), "{found} > {}", entry.bound);
    let head = generated.files[std::path::Path::new("c/corrected_counts.h")].replace("\n *         ", " ");
    for (effect, size) in [
        ("turn_slope", "-9.00e-1 deg a turn, up to 4.50e-1 deg from the middle"),
        ("read_lag", "up to 6.80e-1 deg at the recorded speed"),
        ("backlash", "up to 1.10e-2 deg"),
        ("thermal_zero_drift", "up to 6.00e-2 deg"),
        ("time_drift", "of a size that the file does not tell"),
        ("gear", "its period is no part of the turn; it is up to 5.00e-2 deg"),
    ] {
        let said = entry.left_out.iter().find(|out| out.starts_with(&format!("{effect}: ")));
        let said = said.unwrap_or_else(|| panic!("{effect}: {:?}", entry.left_out));
        assert!(said.contains(size), "{said}");
        assert!(head.contains(said.as_str()), "{said}: {head}");
    }
    assert!(swept(&generated, &file, &options).holds());
    // Nothing says what the recording showed, so there is no budget; with a diagnosis, all that is left out counts.
    assert!(generated.certificate.budgets.is_empty());
    let diagnosis =
        Diagnosed { verdict: "explained".into(), before_rms: 1.3, after_rms: 0.05, noise_floor: 0.05 };
    let known = Coefficients { diagnosis: Some(diagnosis), ..file };
    let budget = generate(&known, "", &options).unwrap().certificate.budgets[0].budget.clone();
    // A lag changes its sign with the direction.
    let largest = |source: &str| budget.components.iter().find(|c| c.source == source).unwrap().value;
    assert!(largest("left_out") + largest("direction") > 0.45 + 0.68 + 0.011 + 0.06, "{budget:?}");
}

/// A base of order 1 is a constant and a slope over the turn; periods that are parts of the turn are its harmonics.
#[test]
fn a_slope_of_the_base_and_parts_of_the_turn() {
    let options = options(Encoder { bits: Some(12), ..Encoder::default() });
    let mut file = usual();
    file.set_base(vec![137.3 - 20.0 * 0.002, 0.002]);
    file.base.centre = 160.0;
    let Operator::Periodic(periodic) = &mut file.terms[0].operator else { panic!("harmonics") };
    *periodic = Periodic { period: 360.0, harmonics: vec![1, 2] };
    file.terms[0].coefficients.truncate(4);
    let fourth = Operator::Periodic(Periodic { period: 90.0, harmonics: vec![1] });
    file.terms.push(Term { operator: fourth, coefficients: vec![0.02, -0.03], ..file.terms[0].clone() });
    let generated = generate(&file, "", &options).unwrap();
    let entry = &generated.certificate.routines[0];
    assert_eq!(entry.left_out.len(), 1, "{:?}", entry.left_out);
    assert!(entry.left_out[0].contains("+7.20e-1 deg a turn"), "{:?}", entry.left_out);
    let found = worst(&usual(), &compiled(&generated, 4096), 4096, 4096) * 360.0 / 4096.0;
    assert!(found <= entry.bound * (1.0 + 1e-9), "{found} > {}", entry.bound);
    file.set_base(vec![1.0, 0.1, 0.01]);
    assert!(matches!(
        generate(&file, "", &options),
        Err(GenerateError::Turn(TurnError::Polynomial { order: 2 }))
    ));
}

/// In degrees, a word whose rounding is small beside the noise is taken, and said.
#[test]
fn the_noise_tells_the_width_of_the_word() {
    let options = options(Encoder::default());
    for (noise_floor, last) in [(0.05, 65_535.0), (1.0, 2047.0), (1e-9, 262_143.0)] {
        let mut file = usual();
        let verdict = "explained".to_string();
        file.diagnosis = Some(Diagnosed { verdict, before_rms: 1.3, after_rms: noise_floor, noise_floor });
        let options =
            Options { encoder: Encoder { flash_bytes: Some(1 << 16), ..options.encoder }, ..options.clone() };
        let generated = generate(&file, "", &options).unwrap();
        assert_eq!(generated.certificate.routines[0].range.to, last);
        assert!(generated.files[std::path::Path::new("c/corrected_counts.h")].contains("none were named"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Any encoder: the stated bound is that of the fitter's own solution.
    #[test]
    fn the_bound_holds_for_any_encoder(
        bits in 10..=12u32,
        finer in 0..=3u32,
        zero in -8192.0..8192.0f64,
        waves in prop::collection::vec(-0.002..0.002f64, 2..12),
        core in prop::sample::select(vec![Core::CortexM0, Core::CortexM4f]),
        bound in 0.51..2.0f64,
    ) {
        let counts = 2f64.powi(bits as i32);
        let waves: Vec<f64> = waves[..waves.len() / 2 * 2].iter().map(|w| w * counts).collect();
        let file = encoder(counts, zero, &waves);
        let wanted = Encoder { output_bits: Some(bits + finer), core: Some(core), flash_bytes: Some(1 << 16), ..Encoder::default() };
        let lsb = 0.5f64.powi(finer as i32);
        let generated = generate(&file, "", &Options { bound: Some(bound * lsb), ..options(wanted) }).unwrap();
        let entry = &generated.certificate.routines[0];
        let routine = codegen::turn::choose::choose(&file, &Options { bound: Some(bound * lsb), ..options(wanted) }).unwrap();
        let results: Vec<u32> = (0..1u32 << bits)
            .map(|count| {
                let word = [codegen::interpret::Word::Int(count.into())];
                codegen::interpret::interpret(&routine.program, &word).unwrap().word.bits() as u32
            })
            .collect();
        let found = worst(&file, &results, 1 << bits, 1 << (bits + finer)) * lsb;
        prop_assert!(entry.bound <= bound * lsb);
        prop_assert!(found <= entry.bound * (1.0 + 1e-9), "{found} > {}", entry.bound);
    }
}
