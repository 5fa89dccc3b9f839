//! `codegen` and `codegen check` on the committed `generated/`: reproduced byte for byte, whatever the number
//! of threads, and stale files reported.

use std::fs;
use std::path::{Path, PathBuf};

use arcsmith_tests::programs::{both, program, root, run};

/// The files below `folder`, relative to it, with their bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_path_buf()];
    while let Some(next) = pending.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
            } else {
                found.push((path.strip_prefix(folder).unwrap().to_path_buf(), fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn the_committed_generation_is_up_to_date() {
    for arguments in [vec!["check", "--demo"], vec!["--demo", "--check"]] {
        let output = run("codegen", &root(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
    }
}

/// `cargo run -p codegen` in the workspace needs no argument; the same program anywhere else does.
#[test]
fn cargo_regenerates_what_is_committed() {
    let elsewhere = tempfile::tempdir().unwrap();
    for (folder, code) in [(root(), 0), (elsewhere.path().to_path_buf(), 2)] {
        let output = program("codegen")
            .current_dir(&folder)
            .env("CARGO_PKG_NAME", "codegen")
            .env("CARGO_MANIFEST_DIR", root().join("codegen"))
            .arg("check")
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(code), "{}: {}", folder.display(), both(&output));
    }
    let output = run("codegen", &root(), &["check"]);
    assert_eq!(output.status.code(), Some(2), "{}", both(&output));
}

/// The file of the folder is taken, said, and recorded in the head.
#[test]
fn the_coefficients_of_the_folder_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let data = root().join("fitter/data/calibration.csv").canonicalize().unwrap();
    let fit = |out: &str| {
        fs::write(folder.path().join("m.toml"), MIRROR).unwrap();
        let output = run(
            "arcsmith",
            folder.path(),
            &["fit", data.to_str().unwrap(), "--mirror", "m.toml", "--out", out],
        );
        assert!(output.status.success(), "{}", both(&output));
    };
    let generate = |arguments: &[&str]| run("codegen", folder.path(), arguments);
    fit("a.coefficients.json");
    let output = generate(&["--format", "q31", "--out", "g"]);
    assert!(
        output.status.success() && both(&output).contains("a.coefficients.json, which lies in this folder"),
        "{}",
        both(&output)
    );
    let head = fs::read_to_string(folder.path().join("g/c/corrected_angle.h")).unwrap();
    assert!(head.contains("codegen --coefficients a.coefficients.json --format q31"), "{head}");
    let named =
        generate(&["check", "--coefficients", "a.coefficients.json", "--format", "q31", "--out", "g"]);
    assert_eq!(named.status.code(), Some(0), "{}", both(&named));
    fit("b.coefficients.json");
    let several = generate(&["--out", "h"]);
    assert_eq!(several.status.code(), Some(2), "{}", both(&several));
    assert!(both(&several).contains("a.coefficients.json and b.coefficients.json"), "{}", both(&several));
    fit("coefficients.json");
    let usual = generate(&["--format", "q31", "--out", "h"]);
    assert!(
        usual.status.success() && both(&usual).contains("taken        coefficients.json"),
        "{}",
        both(&usual)
    );
}

const MIRROR: &str = "[geometry]\nprobe_distance_mm = 12.0\ninitial_gap_mm = 0.3\n";

#[test]
fn a_tampered_copy_is_stale_and_the_difference_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files(&root().join("generated")) {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let out = folder.path().to_str().unwrap();
    let check = || run("codegen", &root(), &["check", "--demo", "--out", out]);
    assert_eq!(check().status.code(), Some(0), "{}", both(&check()));

    // One constant of the C is changed, one file of the Rust removed.
    let c = folder.path().join("c/corrected_angle.c");
    let text = fs::read_to_string(&c).unwrap();
    let line = text.lines().position(|line| line.contains("int32_t constants[")).unwrap() + 1;
    let tampered: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(i, l)| if i == line { l.replace('6', "7") } else { l.to_string() })
        .collect();
    fs::write(&c, tampered.join("\n") + "\n").unwrap();
    fs::remove_file(folder.path().join("src/corrected_angle_q31.rs")).unwrap();
    let before = files(folder.path());

    let output = check();
    let said = both(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let (found, expected) = (tampered[line].trim(), text.lines().nth(line).unwrap().trim());
    let place = format!("first in line {}", line + 1);
    for part in [
        "corrected_angle.c",
        "differs in 1 lines",
        &place,
        found,
        expected,
        "corrected_angle_q31.rs is missing",
        "2 of ",
    ] {
        assert!(said.contains(part), "{part:?} is not in:\n{said}");
    }
    assert_eq!(files(folder.path()), before, "check wrote something");

    // Generating again mends it.
    assert_eq!(run("codegen", &root(), &["--demo", "--out", out]).status.code(), Some(0));
    assert_eq!(check().status.code(), Some(0));
}

#[test]
fn generating_twice_gives_the_same_bytes_with_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let committed = files(&root().join("generated"));
    for threads in ["1", "2", "7"] {
        let out = folder.path().join(threads);
        let output = program("codegen")
            .current_dir(root())
            .args(["--demo", "--quiet", "--out", out.to_str().unwrap()])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", both(&output));
        assert_eq!(files(&out), committed, "RAYON_NUM_THREADS={threads}");
    }
}
