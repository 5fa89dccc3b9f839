//! The program `twin` from outside: files, messages and exit codes.

use std::path::Path;
use std::process::{Command, Output};

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_twin")).args(arguments).output().unwrap()
}

fn record(out: &Path, seed: &str) -> Output {
    twin(&["record", "--protocol", "calibration", "--seed", seed, "--out", out.to_str().unwrap()])
}

#[test]
fn one_seed_is_one_file_to_the_byte_compressed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    for (name, seed) in [("a.csv", "5"), ("b.csv", "5"), ("c.csv", "6"), ("a.csv.gz", "5"), ("b.csv.gz", "5")]
    {
        assert!(record(&file(name), seed).status.success(), "{name}");
    }
    let read = |name: &str| std::fs::read(file(name)).unwrap();
    assert_eq!(read("a.csv"), read("b.csv"));
    assert_ne!(read("a.csv"), read("c.csv"));
    assert_eq!(read("a.csv.gz"), read("b.csv.gz"));
    let mut unpacked = Vec::new();
    let packed = read("a.csv.gz");
    std::io::copy(&mut flate2::read::GzDecoder::new(&packed[..]), &mut unpacked).unwrap();
    assert_eq!(unpacked, read("a.csv"));
    // Nothing else is left behind.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
}

#[test]
fn the_embedded_default_recording_is_reproduced() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("calibration.csv");
    assert!(record(&out, "1").status.success());
    let embedded = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fitter/data/calibration.csv");
    assert!(std::fs::read(&out).unwrap() == std::fs::read(embedded).unwrap(), "fitter/data is stale");
}

#[test]
fn bad_input_gets_one_message_exit_code_2_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(at("folder.csv")).unwrap();
    let good = at("good.csv");
    let cases: [(&[&str], &str); 8] = [
        (&["--protocol", "calibration", "--seed", "1", "--out", &at("missing/x.csv")], "cannot write"),
        (&["--protocol", "calibration", "--seed", "1", "--out", &at("folder.csv")], "directory"),
        (&["--protocol", "calibration", "--seed", "1", "--out", &at("x.txt")], ".csv.gz"),
        (&["--protocol", "slow", "--seed", "1", "--out", &good], "verification"),
        (&["--protocol", "calibration", "--seed", "one", "--out", &good], "--seed"),
        (&["--protocol", "calibration", "--seed", "-1", "--out", &good], "-1"),
        (&["--protocol", "calibration", "--out", &good], "--seed"),
        (&["--protocol", "calibration", "--seed", "1"], "--out"),
    ];
    for (arguments, message) in cases {
        let output = twin(&[&["record"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(message), "{arguments:?} said {said}");
        assert!(output.stdout.is_empty());
    }
    // Only the folder that was made above.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
