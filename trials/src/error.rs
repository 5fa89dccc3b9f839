//! Why a campaign ended early.

use std::path::PathBuf;

use fitter::RecordingError;
use fitter::output::OutputError;
use twin::dynamic::RunError;

fitter::errors! {
    /// See the module.
    #[derive(Debug)]
    pub enum CampaignError {
        Unstarted { program: PathBuf, reason: std::io::ErrorKind } => at(program) says("could not be started: {reason}");
        /// No draw had the wanted strength within the ranges of the parameters, and could be seen.
        Undrawn { group: String, seed: u64, tries: u32 } =>
            says("no {group} trial could be drawn from the seed {seed} in {tries} tries")
            mend("take another seed") by(seed);
        Write { path: PathBuf, reason: std::io::ErrorKind } =>
            at(path) says("cannot be written ({reason})") mend("name a folder that can be written") by(out);
        Occupied { path: PathBuf } =>
            at(path) found("files that no campaign wrote")
            mend("name a folder that is new, empty, or of an earlier campaign") by(out);
        Threads(count: usize) => says("{count} threads could not be started") mend("ask for fewer") by(jobs);
        Unreadable { path: PathBuf, reason: std::io::ErrorKind, expected: &'static str } =>
            at(path) says("cannot be read ({reason})") expected("{expected}");
        /// With line and column.
        Form { path: PathBuf, reason: serde_json::Error, expected: &'static str } =>
            at(path) says("cannot be understood ({reason})") expected("{expected}");
        Reading { path: PathBuf, line: usize } =>
            at(path) line(line) says("is no reading") expected("numbers in the columns of a calibration");
        Refused { program: &'static str, what: &'static str, reason: String } =>
            says("{program} refused {what}: {reason}");
        Angles { path: PathBuf } =>
            at(path) says("not one corrected reading for each row of slit-test.csv.gz");
    }
    from { Motion(RunError), Recording(RecordingError), Output(OutputError) }
}
