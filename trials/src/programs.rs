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

/// What the programs are told of the device, as an option and the file in the folder of the recordings.
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

/// The programs.
#[derive(Debug, Clone)]
pub struct Programs {
    diagnose: PathBuf,
    fitter: PathBuf,
}

impl Programs {
    /// Finds them beside the running program.
    ///
    /// # Errors
    /// [`ProgramError::Missing`].
    pub fn find() -> Result<Self, ProgramError> {
        Ok(Self { diagnose: beside("diagnose", "diagnosis")?, fitter: beside("fitter", "fitter")? })
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
        let mut command = Command::new(&self.diagnose);
        command.current_dir(blind).env_clear().args(files).args([nominal.option(), nominal.file()]);
        command.arg("--out").arg(out).arg("--no-report").args(["--jobs", &jobs.to_string()]).args(options);
        run(command, &self.diagnose)
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
        let mut command = Command::new(&self.fitter);
        command.env_clear().arg("apply").arg(recording).arg("--coefficients").arg(coefficients);
        command.arg("--out").arg(out);
        run(command, &self.fitter)
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

fn beside(name: &'static str, package: &'static str) -> Result<PathBuf, ProgramError> {
    let file = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let folder =
        std::env::current_exe().ok().and_then(|own| own.parent().map(Path::to_owned)).unwrap_or_default();
    let expected = folder.join(file);
    if expected.is_file() { Ok(expected) } else { Err(ProgramError::Missing { name, package, expected }) }
}
