//! The program under test, run as a separate process that is given files and nothing else.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use fitter::progress::Progress;

use crate::error::CampaignError;

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
        self.option_and_file()[1]
    }

    fn option_and_file(self) -> [&'static str; 2] {
        match self {
            Self::Mirror => ["--mirror", "mirror.toml"],
            Self::Plant => ["--plant", "plant.toml"],
        }
    }
}

/// The program with its commands `fit`, `apply`, `diagnose` and `fleet`, and who watches what is done with it.
pub struct Programs<'a> {
    /// Where it lies.
    pub path: PathBuf,
    /// Who is told how far the work is.
    pub watch: &'a dyn Progress,
}

impl Programs<'_> {
    /// Tells who watches that something of so many steps begins.
    pub fn begin(&self, what: &str, steps: usize) {
        self.watch.doing(what);
        self.watch.steps(steps as u64);
    }

    fn command(&self, name: &str) -> Command {
        let mut command = Command::new(&self.path);
        command.env_clear().arg(name).stdin(Stdio::null());
        command
    }

    /// Whether it accepted what it was given, or what it said.
    fn run(&self, mut command: Command) -> Result<Result<(), String>, CampaignError> {
        let output = command
            .output()
            .map_err(|e| CampaignError::Unstarted { program: self.path.clone(), reason: e.kind() })?;
        Ok(match output.status.success() {
            true => Ok(()),
            false => Err(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
        })
    }

    /// Diagnoses recordings of the folder `blind`, by name, into `out`, with further options; whether the program
    /// accepted them all. The program stands in `blind` and knows no other folder.
    ///
    /// # Errors
    /// [`CampaignError::Unstarted`].
    pub fn diagnose(
        &self,
        nominal: Nominal,
        blind: &Path,
        files: &[String],
        out: &Path,
        options: &[&str],
        jobs: usize,
    ) -> Result<Result<(), String>, CampaignError> {
        let mut command = self.command("diagnose");
        command.current_dir(blind).args(files).args(nominal.option_and_file());
        command.arg("--out").arg(out).arg("--no-report").args(["--jobs", &jobs.to_string()]).args(options);
        self.run(command)
    }

    /// Compares two recordings of the folder `blind`, the answer written to `out`; whether the program accepted them.
    ///
    /// # Errors
    /// [`CampaignError::Unstarted`].
    pub fn compare(
        &self,
        blind: &Path,
        recordings: [&str; 2],
        nominal: Nominal,
        out: &Path,
    ) -> Result<Result<(), String>, CampaignError> {
        let mut command = self.command("compare");
        command.current_dir(blind).args(recordings).args(nominal.option_and_file());
        command.arg("--out").arg(out).args(["--no-report", "--quiet"]);
        self.run(command)
    }

    /// Diagnoses `recordings` of a folder as a fleet, with its `mirror.toml` and `lots.csv`, into its `results`; whether it was
    /// accepted.
    ///
    /// # Errors
    /// [`CampaignError::Unstarted`].
    pub fn fleet(&self, folder: &Path, jobs: usize) -> Result<Result<(), String>, CampaignError> {
        let mut command = self.command("fleet");
        command.current_dir(folder).args(["recordings", "--mirror", "mirror.toml", "--lots", "lots.csv"]);
        command.args(["--out", "results", "--quiet", "--jobs", &jobs.to_string()]);
        self.run(command)
    }

    /// The coefficients of the base model alone, fitted to a recording of the folder `blind` and written to `out`;
    /// whether it was accepted.
    ///
    /// # Errors
    /// [`CampaignError::Unstarted`].
    pub fn fit(
        &self,
        blind: &Path,
        recording: &str,
        out: &Path,
    ) -> Result<Result<(), String>, CampaignError> {
        let mut command = self.command("fit");
        command.current_dir(blind).arg(recording).args(Nominal::Mirror.option_and_file());
        command.arg("--out").arg(out);
        self.run(command)
    }

    /// The corrected readings of `recording` by `coefficients`, written to `out`; whether they were accepted.
    ///
    /// # Errors
    /// [`CampaignError::Unstarted`].
    pub fn apply(
        &self,
        recording: &Path,
        coefficients: &Path,
        out: &Path,
    ) -> Result<Result<(), String>, CampaignError> {
        let mut command = self.command("apply");
        command.arg(recording).arg("--coefficients").arg(coefficients);
        command.arg("--out").arg(out);
        self.run(command)
    }
}
