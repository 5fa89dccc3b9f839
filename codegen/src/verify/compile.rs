//! Compilers of the user's machine: found through `RUSTC` and `CC`, started, and quoted when they refuse.

use std::io;
use std::path::Path;
use std::process::{Command, Output};

use super::VerifyError;

/// A program to be run, named as the user would find it.
#[derive(Debug, Clone)]
pub struct Tool {
    /// Path or name.
    pub program: String,
    /// How to get it, in a few words.
    pub install: &'static str,
}

impl Tool {
    /// The Rust compiler.
    pub fn rustc() -> Self {
        Tool {
            program: variable("RUSTC", "rustc"),
            install: "install Rust from https://rustup.rs, or set RUSTC",
        }
    }

    /// The C compiler.
    pub fn cc() -> Self {
        Tool { program: variable("CC", "cc"), install: "install gcc or clang, or set CC" }
    }

    /// Any other program.
    pub fn named(program: &str, install: &'static str) -> Self {
        Tool { program: program.into(), install }
    }

    /// Whether it is there.
    pub fn is_there(&self) -> bool {
        Command::new(&self.program).arg("--version").output().is_ok()
    }

    /// Runs it and gives what it printed, whatever its exit code.
    ///
    /// # Errors
    /// [`VerifyError::Missing`] where it cannot be started.
    pub fn output(&self, arguments: &[&str], folder: &Path) -> Result<Output, VerifyError> {
        let started = Command::new(&self.program).args(arguments).current_dir(folder).output();
        started.map_err(|cause| match cause.kind() {
            io::ErrorKind::NotFound => {
                VerifyError::Missing { program: self.program.clone(), install: self.install }
            }
            _ => VerifyError::Run { program: self.program.clone(), cause },
        })
    }

    /// Runs it and gives its standard output.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] with the first lines of its messages where the exit code is not 0.
    pub fn run(&self, arguments: &[&str], folder: &Path) -> Result<String, VerifyError> {
        let output = self.output(arguments, folder)?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        Err(VerifyError::Refused { program: self.program.clone(), message: messages(&output) })
    }
}

/// The first lines of what a program complained of.
pub fn messages(output: &Output) -> String {
    let text = [&output.stderr[..], &output.stdout[..]].concat();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).take(12).collect();
    if lines.is_empty() { format!("{}", output.status) } else { lines.join("\n") }
}

fn variable(name: &str, otherwise: &str) -> String {
    std::env::var(name).ok().filter(|v| !v.is_empty()).unwrap_or_else(|| otherwise.into())
}
