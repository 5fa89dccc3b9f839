//! Compilers of the user's machine, and the programs that are made with them around generated files.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use minijinja::Value;

use super::VerifyError;
use crate::language::{self, Checker, Language};
use crate::render::Renderer;

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

/// Where generated files lie, and where programs are made around them.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// The folder of the generated files, absolute.
    pub generated: &'a Path,
    /// Their base name.
    pub base: &'a str,
    /// The folder of the programs.
    pub build: &'a Path,
}

/// In which language, and how carefully, a program is made.
#[derive(Debug, Clone, Copy)]
pub struct How {
    /// The language.
    pub language: &'static dyn Language,
    /// How its files are compiled.
    pub checker: &'static dyn Checker,
    /// Whether undefined behaviour is watched for.
    pub sanitized: bool,
    /// Whether warnings are errors and overflow ends the program: not where billions of inputs are swept.
    pub strict: bool,
}

impl How {
    /// Every language that can be checked, and where asked for those again that can be watched.
    pub fn all(sanitize: bool) -> Vec<How> {
        let how = |language: &&'static dyn Language| {
            let checker = language.checker()?;
            Some(How { language: *language, checker, sanitized: false, strict: false })
        };
        let plain: Vec<How> = language::ALL.iter().filter_map(how).collect();
        let watched = plain.iter().filter(|how| sanitize && how.checker.watches());
        let watched: Vec<How> = watched.map(|how| How { sanitized: true, ..*how }).collect();
        [plain, watched].concat()
    }

    /// The same with warnings as errors.
    #[must_use]
    pub fn strictly(self) -> How {
        How { strict: true, ..self }
    }
}

impl Place<'_> {
    /// Makes a program of the language's template of a `kind`, around the generated files.
    ///
    /// # Errors
    /// [`VerifyError`] where there is no compiler, or it refuses the generated files.
    pub fn program(&self, how: How, stem: &str, kind: &str, context: Value) -> Result<PathBuf, VerifyError> {
        let stem = format!("{stem}_{}{}", how.language.name(), if how.sanitized { "_ub" } else { "" });
        let source = self.build.join(format!("{stem}.{}", how.checker.extension()));
        let template = format!("verify/{kind}.{}", how.checker.extension());
        write(&source, &Renderer::new()?.render(&template, context)?)?;
        let executable = self.build.join(&stem);
        let (tool, arguments) = how.checker.compiler(self, how, &source, &executable);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        tool.run(&arguments, self.build)?;
        Ok(executable)
    }
}

/// Runs a program on what it reads from its standard input.
pub(crate) fn fed(program: &Path, input: Vec<u8>) -> Result<Output, VerifyError> {
    let failed = |cause| VerifyError::Run { program: program.display().to_string(), cause };
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    let mut pipe = child.stdin.take();
    // A program that ends early closes the pipe; its exit code says so.
    let feeder = std::thread::spawn(move || pipe.take().map(|mut pipe| pipe.write_all(&input)));
    let output = child.wait_with_output().map_err(failed)?;
    let _ = feeder.join();
    Ok(output)
}

/// Words of 32 bits, as programs print them.
pub fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Writes a file.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), VerifyError> {
    std::fs::write(path, text).map_err(|cause| VerifyError::Write { path: path.into(), cause })
}

/// A temporary folder.
pub(crate) fn temporary() -> Result<tempfile::TempDir, VerifyError> {
    tempfile::tempdir().map_err(|cause| VerifyError::Write { path: "temporary folder".into(), cause })
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
