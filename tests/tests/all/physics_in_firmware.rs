//! From a recording of a real sensor to firmware that corrects what was found in it: a beam-line slit whose resolver
//! errs with its turn. Diagnosed on one move, generated, compiled, and run on the readings of another.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use arcsmith_tests::native::Native;
use arcsmith_tests::programs::{both, run};
use arcsmith_tests::recordings::real;
use arcsmith_tests::toolchain::available;
use codegen::certificate::Certificate;
use codegen::options::OutOfRange;
use fitter::Recording;
use fitter::recording::Purpose;

/// Left on the test, the origin of the step counter apart.
const LEFT_UM: f64 = 1.0;

#[test]
fn the_generated_routine_corrects_a_slit_on_another_move() {
    let skipped = "the generated correction of a real sensor's periodic error";
    let files = ["slit-train.csv.gz", "slit-test.csv.gz", "slit.toml"].map(|name| real(name, skipped));
    let [Some(train), Some(test), Some(mirror)] = files else { return };
    let [train, test, mirror] = [train, test, mirror].map(|path| path.canonicalize().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let run = |program: &str, arguments: &[&str]| {
        let output = run(program, folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{program} {arguments:?}:\n{}", both(&output));
    };
    let path = |path: &Path| path.to_str().unwrap().to_string();
    run("arcsmith", &["diagnose", &path(&train), "--mirror", &path(&mirror), "--out", "d", "--no-report"]);

    // The test lies beyond what was recorded.
    let recording = Recording::read_for(&test, Purpose::Apply, &mut |_| {}).unwrap();
    let readings: Vec<f64> = (0..recording.rows()).map(|row| recording.reading(row)).collect();
    let least = readings.iter().copied().fold(f64::INFINITY, f64::min);
    let most = readings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (from, to) = ((least - 0.01).to_string(), (most + 0.01).to_string());
    let coefficients = "d/slit-train.coefficients.json";
    let arguments = [
        "--coefficients",
        coefficients,
        "--from",
        &from,
        "--to",
        &to,
        "--extrapolate",
        "--full-scale",
        "32",
        "--bound",
        "0.0001mm",
        "--out",
        "slit",
    ];
    run("codegen", &arguments);
    let certificate = fs::read_to_string(folder.path().join("slit/certificate.json")).unwrap();
    let certificate: Certificate = serde_json::from_str(&certificate).unwrap();
    let names = ["c/corrected_mm.h", "c/corrected_mm.c"];
    let sources: BTreeMap<_, _> = names
        .map(|name| (name.into(), fs::read_to_string(folder.path().join("slit").join(name)).unwrap()))
        .into();
    if !available("gcc", skipped) {
        return;
    }
    let entry = certificate.routines.iter().find(|r| r.language == "c").unwrap();
    let words: Vec<[u32; 2]> =
        readings.iter().map(|mm| [(mm / 32.0 * 2f64.powi(31)).round() as i32 as u32, 0]).collect();
    let results = Native::c(&sources, entry, OutOfRange::Clamp, "gcc").run(&words);
    let errors_um: Vec<f64> = (results.iter().enumerate())
        .map(|(row, given)| {
            let corrected_mm = f64::from(given.bits as i32) * entry.output.lsb;
            1e3 * (corrected_mm - recording.reference(row).unwrap())
        })
        .collect();
    let mean = errors_um.iter().sum::<f64>() / errors_um.len() as f64;
    let left_um =
        (errors_um.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors_um.len() as f64).sqrt();
    println!("slit: {left_um:.3} µm left by the generated C on another move, bound {:.1e} mm", entry.bound);
    assert!(left_um <= LEFT_UM, "{left_um} µm");
}
