//! The compiled C and Rust, over a random walk of 20 000 steps.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use codegen::generate::generate;

use super::expression::expressed;
use super::*;

#[test]
fn compiled_c_and_rust_give_the_interpreters_bits() {
    let (device, words) = walk();
    let options = Options { period_s: Some(0.002), ..options() };
    let mut coefficients = device.coefficients();
    coefficients.terms.extend([
        term("thermal_lag", Operator::Lag(Lag::of("temperature_c", 400.0, device.mean_c)), vec![0.2]),
        term("read_lag", Operator::Rate(Rate::of("angle_arcsec")), vec![1e-5]),
        term("periodic_error", Operator::Periodic(Periodic::of(700.0, 1)), vec![2.0, -1.0]),
        term("screw_error", Operator::Periodic(Periodic::of(1130.0, 1)), vec![1.0, 3.0]),
        // It has a table of its own beside theirs.
        term("fan", expressed("k * sin(temperature_c / 1 [K])"), vec![2.0]),
        term("local_defect", Operator::Gaussian(Gaussian::of("angle_arcsec", 400.0, 90.0)), vec![3.0]),
        term(
            "warmup_drift",
            Operator::Exponential(Exponential { observable: "t_s".into(), start: 0.0, scale: 8.0 }),
            vec![-4.0],
        ),
        term("knee", Operator::Exponential(exponential("temperature_c", 25.0, 4.0)), vec![1.0]),
        term("click", Operator::Step(Step { observable: "temperature_c".into(), at: 27.0 }), vec![0.7]),
    ]);
    let generated = generate(&coefficients, "0", &options).unwrap();
    let expected = interpreted(&generated.routines[0], &words);
    let folder = tempfile::tempdir().unwrap();
    for (path, text) in &generated.files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let sequence = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sequence");
    std::fs::create_dir_all(folder.path().join("main")).unwrap();
    std::fs::copy(sequence.join("run.rs"), folder.path().join("main/run.rs")).unwrap();
    let input: Vec<u8> = words
        .iter()
        .flat_map(|(w, count)| [w.to_le_bytes(), i32::from(*count).to_le_bytes()].concat())
        .collect();
    let c: Vec<String> =
        ["-O2", "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-Ic", "c/corrected_angle.c"]
            .iter()
            .map(|s| (*s).to_string())
            .chain([sequence.join("run.c").display().to_string(), "-o".into(), "run-c".into()])
            .collect();
    let rust =
        ["--edition=2021", "-O", "-Coverflow-checks=on", "-Dwarnings", "main/run.rs", "-o", "run-rust"];
    let rust: Vec<String> = rust.iter().map(|s| (*s).to_string()).collect();
    for (compiler, arguments, program) in
        [("gcc", &c, "run-c"), ("clang", &c, "run-c"), ("rustc", &rust, "run-rust")]
    {
        let built = match Command::new(compiler).args(arguments).current_dir(&folder).output() {
            Ok(built) => built,
            Err(_) => {
                println!("skipped: {compiler} is not installed");
                continue;
            }
        };
        assert!(built.status.success(), "{compiler}: {}", String::from_utf8_lossy(&built.stderr));
        let mut run = Command::new(folder.path().join(program))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut pipe = run.stdin.take().unwrap();
        let bytes = input.clone();
        let feeder = std::thread::spawn(move || pipe.write_all(&bytes).unwrap());
        let output = run.wait_with_output().unwrap();
        feeder.join().unwrap();
        let results: Vec<i32> =
            output.stdout.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(results, expected, "{compiler}");
    }
}
