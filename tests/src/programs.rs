//! The project's programs, run from outside.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The root of the project.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A program of the workspace, as built from the present sources, or from the folder that `ARCSMITH_PROGRAMS`
/// names, where they are built already.
///
/// # Panics
/// Where the workspace does not build, or has no such program.
pub fn program(name: &str) -> Command {
    if let Some(folder) = std::env::var_os("ARCSMITH_PROGRAMS") {
        let path = PathBuf::from(folder).join(name);
        assert!(path.is_file(), "{} is not there; build it, or unset ARCSMITH_PROGRAMS", path.display());
        return Command::new(path);
    }
    static PROGRAMS: OnceLock<HashMap<String, PathBuf>> = OnceLock::new();
    let programs = PROGRAMS.get_or_init(build);
    match programs.get(name) {
        Some(path) => Command::new(path),
        None => panic!("the workspace has no program {name}: {programs:?}"),
    }
}

/// Runs a program in `folder` with arguments.
///
/// # Panics
/// Where it cannot be started.
pub fn run<S: AsRef<std::ffi::OsStr>>(name: &str, folder: &Path, arguments: &[S]) -> Output {
    let mut command = program(name);
    command.current_dir(folder).args(arguments).output().unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Both streams of an output, for messages.
pub fn both(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Builds all programs with the profile and, naming the whole workspace with its tests, the very features of
/// `cargo test --workspace`, so that nothing is compiled twice. Cargo says where they are.
fn build() -> HashMap<String, PathBuf> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(root()).args(["build", "--workspace", "--bins", "--tests", "--message-format=json"]);
    if !cfg!(debug_assertions) {
        command.arg("--release");
    }
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let executable = |line: &str| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        let is_program = message["target"]["kind"][0] == "bin" && message["profile"]["test"] == false;
        let (name, path) = (message["target"]["name"].as_str()?, message["executable"].as_str()?);
        is_program.then(|| (name.to_string(), PathBuf::from(path)))
    };
    String::from_utf8_lossy(&output.stdout).lines().filter_map(executable).collect()
}
