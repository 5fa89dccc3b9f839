//! The program from outside, where it cannot do its work.

use std::path::Path;
use std::process::{Command, Output};

/// A copy of the program in a folder without the programs that it needs, or with stand-ins that accept all and
/// write nothing.
fn copy(folder: &Path) -> std::path::PathBuf {
    let program = folder.join(format!("trials{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(env!("CARGO_BIN_EXE_trials"), &program).unwrap();
    program
}

fn run(program: &Path, arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(program);
    command
        .env_remove("ARCSMITH_RECORDINGS")
        .env_remove("ARCSMITH_EXAMPLES")
        .args(arguments)
        .current_dir(folder);
    loop {
        match command.output() {
            // A process that another test starts holds the copy open until it runs.
            Err(error) if error.kind() == std::io::ErrorKind::ExecutableFileBusy => {
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
            output => return output.unwrap(),
        }
    }
}

#[test]
fn a_missing_program_is_named_with_the_command_that_builds_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(&copy(folder.path()), &["static", "--out", "out"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("cargo build --release -p diagnosis"), "{message}");
    assert!(!folder.path().join("out").exists());
}

#[cfg(unix)]
#[test]
fn a_folder_with_other_files_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let program = copy(folder.path());
    for name in ["diagnose", "fitter"] {
        std::fs::copy("/bin/true", folder.path().join(name)).unwrap();
    }
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("precious.txt"), "mine").unwrap();
    let output = run(&program, &["static", "--trials", "7", "--nulls", "1", "--out", "out"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("give --out a folder that is new"), "{message}");
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
}

/// A `diagnose` that answers nothing must cost every figure, not pass for silence.
#[cfg(unix)]
#[test]
fn no_answer_is_no_right_answer_and_the_seal_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let program = copy(folder.path());
    for name in ["diagnose", "fitter"] {
        std::fs::copy("/bin/true", folder.path().join(name)).unwrap();
    }
    let arguments =
        ["static", "--trials", "7", "--nulls", "3", "--jobs", "1", "--skip-without", "--out", "out"];
    let output = run(&program, &arguments, folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let seal = text.lines().next().unwrap().rsplit(' ').next().unwrap().to_owned();
    let truth = std::fs::read(folder.path().join("out/truth.jsonl")).unwrap();
    let hash: String = {
        use sha2::{Digest, Sha256};
        Sha256::digest(&truth).iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!(seal, hash);
    let report = std::fs::read_to_string(folder.path().join("out/report.json")).unwrap();
    assert!(report.contains("100.00 % (3/3)"), "{report}");
    // The recordings stand alone: no truth, and names that say nothing.
    for entry in std::fs::read_dir(folder.path().join("out/recordings")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(name == "mirror.toml" || (name.starts_with('r') && name.ends_with(".csv")), "{name}");
    }
}

/// As above, of moving mechanisms.
#[cfg(unix)]
#[test]
fn no_answer_is_no_right_answer_in_motion_either() {
    let folder = tempfile::tempdir().unwrap();
    let program = copy(folder.path());
    for name in ["diagnose", "fitter"] {
        std::fs::copy("/bin/true", folder.path().join(name)).unwrap();
    }
    let arguments = ["dynamic", "--trials", "5", "--jobs", "1", "--out", "out"];
    let output = run(&program, &arguments, folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let report = std::fs::read_to_string(folder.path().join("out/report.json")).unwrap();
    assert!(report.contains("100.00 % (1/1") && report.contains("refused"), "{report}");
    let truth = std::fs::read_to_string(folder.path().join("out/truth.jsonl")).unwrap();
    assert_eq!(truth.lines().count(), 5);
    for entry in std::fs::read_dir(folder.path().join("out/recordings")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(name == "plant.toml" || (name.starts_with('r') && name.ends_with(".csv.gz")), "{name}");
    }
}
