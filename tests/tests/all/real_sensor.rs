//! The whole path on a recording of a real sensor: a beam-line slit, resolver against step counter. Fitted on
//! one move, applied to another range, generated with a bound in millimetres, compiled, held to the model.

use std::fs;

use approx::assert_abs_diff_eq;
use arcsmith_tests::inputs::Meaning;
use arcsmith_tests::judge;
use arcsmith_tests::native::{Given, Native};
use arcsmith_tests::programs::{both, run};
use arcsmith_tests::recordings::real;
use arcsmith_tests::toolchain::{C_COMPILERS, available};
use codegen::certificate::Certificate;
use codegen::format::Format;
use codegen::options::{OutOfRange, RoutineOptions};
use fitter::Recording;
use fitter::recording::Purpose;

/// What is asked of the generated routine.
const BOUND_MM: f64 = 0.0001;
const INPUTS: usize = 100_000;

#[test]
fn a_slit_is_fitted_applied_and_generated() {
    let skipped = "the path on a real sensor, the slit of a beam line";
    let files = ["slit-train.csv.gz", "slit-test.csv.gz", "slit.toml"].map(|name| real(name, skipped));
    let [Some(train), Some(test), Some(mirror)] = files else { return };
    let [train, test, mirror] = [train, test, mirror].map(|path| path.canonicalize().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let run = |program: &str, arguments: &[&str]| {
        let output = run(program, folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{program} {arguments:?}:\n{}", both(&output));
        both(&output)
    };

    // Fitted, with order selection.
    let path = |path: &std::path::Path| path.to_str().unwrap().to_string();
    run("arcsmith", &["fit", &path(&train), "--mirror", &path(&mirror), "--out", "c.json"]);
    let coefficients = fitter::coefficients::read(&folder.path().join("c.json")).unwrap();
    assert_eq!(coefficients.units.statistics, "mm");
    let selection = coefficients.order_selection.as_ref().unwrap();
    assert_eq!(selection.held_out_by, "contiguous block");

    // Applied outside the trained range: a warning, every row marked, and only what extrapolates is used.
    let said = run("arcsmith", &["apply", &path(&test), "--coefficients", "c.json", "--out", "a.csv"]);
    assert!(said.contains("warning") && said.contains("outside the calibrated range"), "{said}");
    let text = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let mut rows = text.lines();
    assert_eq!(rows.next(), Some("t_s,corrected_mm,extrapolated"));
    let recording = Recording::read_for(&test, Purpose::Apply, &mut |_| {}).unwrap();
    let mut errors_mm = Vec::new();
    for (row, line) in rows.enumerate() {
        let fields: Vec<&str> = line.split(',').collect();
        let outside = !coefficients.valid_range.contains(recording.reading(row));
        assert_eq!(fields[2] == "1", outside, "row {row}");
        assert!(outside, "the test lies wholly outside the trained range");
        errors_mm.push(fields[1].parse::<f64>().unwrap() - recording.reference(row).unwrap());
    }
    assert_eq!(errors_mm.len(), recording.rows());
    // The zero of the step counter is another one; a straight line leaves 14.9 µm (rms).
    let mean = errors_mm.iter().sum::<f64>() / errors_mm.len() as f64;
    let rms_mm =
        (errors_mm.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors_mm.len() as f64).sqrt();
    println!(
        "slit: order {}, {:.1} µm left on the test, offset removed",
        coefficients.base.order,
        rms_mm * 1e3
    );
    assert_abs_diff_eq!(rms_mm, 0.015, epsilon = 0.003);

    // Generated from the coefficients and, the same again, from the recording.
    let said =
        run("arcsmith", &["generate", "--coefficients", "c.json", "--bound", "0.0001mm", "--out", "slit"]);
    assert!(said.contains("corrected_mm_q31") && said.contains("mm"), "{said}");
    run(
        "arcsmith",
        &[
            "generate",
            "--recording",
            &path(&train),
            "--mirror",
            &path(&mirror),
            "--bound",
            "0.0001mm",
            "--out",
            "again",
        ],
    );
    let certificate = fs::read_to_string(folder.path().join("slit/certificate.json")).unwrap();
    let certificate: Certificate = serde_json::from_str(&certificate).unwrap();
    let again = fs::read_to_string(folder.path().join("again/certificate.json")).unwrap();
    let again: Certificate = serde_json::from_str(&again).unwrap();
    let bounds = |c: &Certificate| c.routines.iter().map(|r| r.bound).collect::<Vec<_>>();
    assert_eq!(bounds(&certificate), bounds(&again));

    // A length instead of an angle: the unit is in names, heads and certificate.
    let names = [
        "Cargo.toml",
        "src/lib.rs",
        "src/corrected_mm_q31.rs",
        "src/corrected_mm_f32.rs",
        "c/corrected_mm.h",
        "c/corrected_mm.c",
    ];
    let files: std::collections::BTreeMap<_, _> = names
        .map(|name| (name.into(), fs::read_to_string(folder.path().join("slit").join(name)).unwrap()))
        .into();
    let head = &files[std::path::Path::new("c/corrected_mm.h")];
    assert!(head.contains("in mm") && !head.contains("arcsec") && !head.contains(" rad"), "{head}");

    // Compiled and held against the model.
    let model = coefficients.error_model();
    for (format, name) in [(Format::Q31, "q31"), (Format::F32, "f32")] {
        let entry = certificate.routines.iter().find(|r| r.format == name).unwrap();
        assert_eq!(entry.unit, "mm");
        assert!(entry.bound <= BOUND_MM);
        let meaning = Meaning::new(RoutineOptions::of(format).input, (entry.range.from, entry.range.to));
        let inputs = meaning.samples(7, INPUTS);
        let rust = Native::rust(&files, entry).run(&inputs);
        for compiler in C_COMPILERS {
            if available(compiler, "the slit's routine in C") {
                let c = Native::c(&files, entry, OutOfRange::Clamp, compiler).run(&inputs);
                assert!(c == rust, "{compiler} and rustc differ");
            }
        }
        let inside = inputs.iter().zip(&rust).filter(|(words, _)| meaning.in_range(**words));
        let error_mm = |(words, given): (&[u32; 2], &Given)| {
            let reading = meaning.reading(*words);
            let (value, reference) =
                (judge::value(entry, &model, given.bits), judge::reference(&model, reading));
            assert_abs_diff_eq!(value, reference, epsilon = entry.bound + judge::slack(&model, reading));
            (value - reference).abs()
        };
        let largest_mm = inside.map(error_mm).fold(0.0, f64::max);
        println!("slit, {name}: largest error {largest_mm:.2e} mm, bound {:.2e} mm", entry.bound);
    }
}
