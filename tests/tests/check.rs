//! `codegen` and `codegen check` on the committed `generated/`: reproduced byte for byte, whatever the number
//! of threads, and stale files told.

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
    for arguments in [vec!["check"], vec!["--check"]] {
        let output = run("codegen", &root(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", both(&output));
    }
}

#[test]
fn a_tampered_copy_is_stale_and_the_difference_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files(&root().join("generated")) {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let out = folder.path().to_str().unwrap();
    let check = || run("codegen", &root(), &["check", "--out", out]);
    assert_eq!(check().status.code(), Some(0), "{}", both(&check()));

    // One constant of the C is changed, one file of the Rust removed.
    let c = folder.path().join("c/corrected_angle.c");
    let text = fs::read_to_string(&c).unwrap();
    let line = text.lines().position(|line| line.contains("/* c0 = ")).unwrap();
    let tampered: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(i, l)| if i == line { l.replace('+', "-") } else { l.to_string() })
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
    assert_eq!(run("codegen", &root(), &["--out", out]).status.code(), Some(0));
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
            .args(["--quiet", "--out", out.to_str().unwrap()])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", both(&output));
        assert_eq!(files(&out), committed, "RAYON_NUM_THREADS={threads}");
    }
}
