//! The programs under test, run as separate processes that are given files and nothing else.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Why a program could not be run.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// It is not beside this one.
    #[error(
        "the program `{name}` is not beside this one ({}); build it: cargo build --release -p {package}",
        .expected.display()
    )]
    Missing {
        /// Its name.
        name: &'static str,
        /// The package that makes it.
        package: &'static str,
        /// Where it was expected.
        expected: PathBuf,
    },
    /// It could not be started.
    #[error("{} could not be started: {reason}", .program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// What the system said.
        reason: std::io::ErrorKind,
    },
}

/// The program that holds all programs.
const FRONT_DOOR: &str = "arcsmith";

/// What is stated to the programs of the device, as an option and the file in the folder of the recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nominal {
    /// The nominal mirror of static recordings.
    Mirror,
    /// The nominal plant of dynamic ones.
    Plant,
}

impl Nominal {
    /// The name of the file.
    pub fn file(self) -> &'static str {
        match self {
            Self::Mirror => "mirror.toml",
            Self::Plant => "plant.toml",
        }
    }

    fn option(self) -> &'static str {
        match self {
            Self::Mirror => "--mirror",
            Self::Plant => "--plant",
        }
    }
}

/// A program, and what stands before its arguments.
#[derive(Debug, Clone)]
struct Program {
    path: PathBuf,
    before: &'static [&'static str],
}

impl Program {
    fn command(&self) -> Command {
        let mut command = Command::new(&self.path);
        command.env_clear().args(self.before);
        command
    }
}

/// The programs.
#[derive(Debug, Clone)]
pub struct Programs {
    diagnose: Program,
    apply: Program,
    fit: Program,
}

impl Programs {
    /// Finds them beside the running program; the front door `arcsmith` holds them itself, and is started anew.
    ///
    /// # Errors
    /// [`ProgramError::Missing`].
    pub fn find() -> Result<Self, ProgramError> {
        let own = std::env::current_exe().unwrap_or_default();
        if own.file_stem().is_some_and(|name| name == FRONT_DOOR) {
            let itself = |before| Program { path: own.clone(), before };
            return Ok(Self {
                diagnose: itself(&["diagnose"]),
                apply: itself(&["apply"]),
                fit: itself(&["fit"]),
            });
        }
        let folder = own.parent().map(Path::to_owned).unwrap_or_default();
        let fitter = |before| Ok(Program { path: beside(&folder, "fitter", "fitter")?, before });
        Ok(Self {
            diagnose: Program { path: beside(&folder, "diagnose", "diagnosis")?, before: &[] },
            apply: fitter(&["apply"])?,
            fit: fitter(&["fit"])?,
        })
    }

    /// Diagnoses recordings of the folder `blind`, by name, into `out`, with effects left out of the catalogue;
    /// whether the program accepted them all. The program stands in `blind` and knows no other folder.
    ///
    /// # Errors
    /// [`ProgramError::Start`].
    pub fn diagnose(
        &self,
        nominal: Nominal,
        blind: &Path,
        files: &[String],
        out: &Path,
        without: Option<&str>,
        jobs: usize,
    ) -> Result<Result<(), String>, ProgramError> {
        let options = without.map_or_else(Vec::new, |id| vec!["--without", id]);
        self.diagnose_with(nominal, blind, files, out, &options, jobs)
    }

    /// The same with further options.
    ///
    /// # Errors
    /// [`ProgramError::Start`].
    pub fn diagnose_with(
        &self,
        nominal: Nominal,
        blind: &Path,
        files: &[String],
        out: &Path,
        options: &[&str],
        jobs: usize,
    ) -> Result<Result<(), String>, ProgramError> {
        let mut command = self.diagnose.command();
        command.current_dir(blind).args(files).args([nominal.option(), nominal.file()]);
        command.arg("--out").arg(out).arg("--no-report").args(["--jobs", &jobs.to_string()]).args(options);
        run(command, &self.diagnose.path)
    }

    /// The coefficients of the base model alone, fitted to a recording of the folder `blind` and written to `out`;
    /// whether it was accepted.
    ///
    /// # Errors
    /// [`ProgramError::Start`].
    pub fn fit(&self, blind: &Path, recording: &str, out: &Path) -> Result<Result<(), String>, ProgramError> {
        let mut command = self.fit.command();
        command.current_dir(blind).arg(recording).args(["--mirror", Nominal::Mirror.file()]);
        command.arg("--out").arg(out);
        run(command, &self.fit.path)
    }

    /// The corrected readings of `recording` by `coefficients`, written to `out`; whether they were accepted.
    ///
    /// # Errors
    /// [`ProgramError::Start`].
    pub fn apply(
        &self,
        recording: &Path,
        coefficients: &Path,
        out: &Path,
    ) -> Result<Result<(), String>, ProgramError> {
        let mut command = self.apply.command();
        command.arg(recording).arg("--coefficients").arg(coefficients);
        command.arg("--out").arg(out);
        run(command, &self.apply.path)
    }
}

fn run(mut command: Command, program: &Path) -> Result<Result<(), String>, ProgramError> {
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|e| ProgramError::Start { program: program.to_owned(), reason: e.kind() })?;
    Ok(if output.status.success() {
        Ok(())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).trim().to_owned())
    })
}

fn beside(folder: &Path, name: &'static str, package: &'static str) -> Result<PathBuf, ProgramError> {
    let expected = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    if expected.is_file() { Ok(expected) } else { Err(ProgramError::Missing { name, package, expected }) }
}
