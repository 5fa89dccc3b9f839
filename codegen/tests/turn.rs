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
use fitter::coefficients::Coefficients;
use fitter::error_model::{ErrorModel, Sensor};
use fitter::terms::{Operator, Periodic, Scope, Term};
use fitter::turn::Turn;
use proptest::prelude::*;

/// An encoder that reports `unit`, with a zero and the amplitudes of cosine and sine of each harmonic.
fn encoder(unit: &str, revolution: f64, zero: f64, waves: &[f64]) -> Coefficients {
    let sensor = Sensor::Direct { unit: unit.into(), revolution: Some(revolution) };
    let model = ErrorModel { sensor, centre: 0.5 * revolution, coefficients: vec![zero] };
    let mut file = Coefficients::of_model(&model, 0.0, revolution, "by hand");
    file.turn = Some(Turn::single(revolution));
    file.terms.push(Term {
        effect: "periodic_error".into(),
        scope: Scope::Device,
        operator: Operator::Periodic(Periodic::of(revolution, (waves.len() / 2) as u16)),
        coefficients: waves.to_vec(),
        covariance: Vec::new(),
    });
    file
}

/// Eccentric by 0.4°, with smaller harmonics.
fn usual() -> Coefficients {
    encoder("deg", 360.0, 137.3, &[0.3, 0.25, -0.1, 0.05, 0.0, 0.0, 0.02, -0.03])
}

fn options(encoder: Encoder) -> Options {
    Options { encoder, ..Options::default() }
}

/// The largest distance of the results of all counts from the fitter's solution, in counts of the result.
fn worst(file: &Coefficients, results: &[u32], input: u32, output: u32) -> f64 {
    let revolution = file.turn.as_ref().unwrap().revolution;
    let counts = 2f64.powi(output as i32);
    (0..1u32 << input)
        .map(|count| {
            let reading = f64::from(count) * revolution / 2f64.powi(input as i32);
            let exact = fitter::turn::corrected(file, reading).unwrap() / revolution * counts;
            let off = f64::from(results[count as usize]) - exact;
            (off - counts * (off / counts).round()).abs()
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
fn compiled(generated: &Generated, bits: u32) -> Vec<u32> {
    let folder = tempfile::tempdir().unwrap();
    let mut all: BTreeMap<PathBuf, String> = generated.files.clone();
    let main = "#include <stdio.h>\n#include \"corrected_counts.h\"\nint main(void) { for (uint32_t c = 0; c < (1u << BITS); ++c) \
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
        .args([&format!("-DBITS={bits}"), "main.c", "corrected_counts.c", "-o", "sweep"])
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
        let wanted = Encoder { bits: Some(bits), output_bits, core: Some(core), flash_bytes };
        let options = options(wanted);
        let generated = generate(&file, "", &options).unwrap();
        let entry = &generated.certificate.routines[0];
        let output = output_bits.unwrap_or(bits);
        let lsb = 360.0 / 2f64.powi(output as i32);
        assert!(entry.bound <= 0.55 * lsb, "{bits} bits: {} of {lsb}", entry.bound);
        let results = compiled(&generated, bits);
        let found = worst(&file, &results, bits, output) * lsb;
        assert!(found <= entry.bound * (1.0 + 1e-9), "{bits} bits: {found} > {}", entry.bound);
        // Nothing is given away: the bound is what the worst count has.
        assert!(found >= entry.bound * (1.0 - 1e-6), "{bits} bits: {found} < {}", entry.bound);
        let report = swept(&generated, &file, &options);
        assert!(report.holds(), "{}", report.text());
        assert_eq!(report.sweeps.len(), 2);
        assert!(report.sweeps.iter().all(|s| s.words >= 1 << bits));
    }
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
    let lines = encoder("counts", 10_000.0, 3.0, &[20.0, 0.0]);
    assert!(matches!(error(&lines, none, None), TurnError::Counts { .. }));
    let counts = encoder("counts", 16384.0, 3.0, &[20.0, 0.0]);
    assert!(matches!(error(&counts, bits(12), None), TurnError::Contradiction { .. }));
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
        let file = encoder("counts", counts, zero, &waves);
        let wanted = Encoder { bits: None, output_bits: Some(bits + finer), core: Some(core), flash_bytes: Some(1 << 16) };
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
        let found = worst(&file, &results, bits, bits + finer) * lsb;
        prop_assert!(entry.bound <= bound * lsb);
        prop_assert!(found <= entry.bound * (1.0 + 1e-9), "{found} > {}", entry.bound);
    }
}
