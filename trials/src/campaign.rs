//! One campaign: draw, write the recordings, seal, have them diagnosed blind, unseal, compare on fresh
//! recordings.

use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;

use crate::answer::{Answer, AnswerError};
use crate::draw::{Trial, Undrawn};
use crate::fresh::{self, Twice};
use crate::plan;
use crate::programs::{ProgramError, Programs};
use crate::score::Case;
use crate::truth::{Group, Truth, seal};

/// Recordings given to one call of `diagnose`.
const BATCH: usize = 40;
/// What the programs are told of the mirror: the paper's, which all devices are built as.
const MIRROR: &str = include_str!("mirror.toml");

/// What a campaign is asked for.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Trials with something concealed.
    pub trials: usize,
    /// Nulls of each noise family.
    pub nulls: usize,
    /// Seed of everything.
    pub seed: u64,
    /// Threads.
    pub jobs: usize,
    /// Whether each effect is left out of the catalogue in turn.
    pub without: bool,
    /// The folder that everything is written into.
    pub out: PathBuf,
}

/// Why a campaign ended early.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A program could not be run.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A trial could not be drawn.
    #[error(transparent)]
    Undrawn(#[from] Undrawn),
    /// A recording could not be written.
    #[error(transparent)]
    Recording(#[from] twin::log::WriteError),
    /// An answer is missing or of another form.
    #[error(transparent)]
    Answer(#[from] AnswerError),
    /// A folder or a file could not be written.
    #[error("{}: cannot be written ({reason}); give --out a folder that can be written", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        reason: std::io::ErrorKind,
    },
    /// The folder is in use for something else.
    #[error(
        "{}: found files that no campaign wrote; give --out a folder that is new, empty, or of an earlier campaign",
        .path.display()
    )]
    Occupied {
        /// The folder.
        path: PathBuf,
    },
    /// The threads could not be started.
    #[error("{0} threads could not be started; give a smaller --jobs")]
    Threads(usize),
}

/// What a campaign brought.
pub struct Outcome {
    /// The trials, unsealed.
    pub cases: Vec<Case>,
    /// SHA-256 of the sealed truth.
    pub sealed: String,
}

/// The folders of a campaign.
struct Folders {
    blind: PathBuf,
    diagnosed: PathBuf,
    without: PathBuf,
    fresh: PathBuf,
    truth: PathBuf,
}

impl Campaign {
    /// Runs it; `sealed` is called with the hash of the truth before anything is diagnosed.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn run(&self, sealed: impl FnOnce(&str, usize)) -> Result<Outcome, CampaignError> {
        let programs = Programs::find()?;
        let folders = self.folders()?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.jobs)
            .build()
            .map_err(|_| CampaignError::Threads(self.jobs))?;
        let trials = pool.install(|| self.draw(&folders))?;
        let mut truths: Vec<&Truth> = trials.iter().map(|t| &t.truth).collect();
        truths.sort_by(|a, b| a.recording.cmp(&b.recording));
        let (truth, hash) = seal(&truths);
        sealed(&hash, trials.len());

        let files: Vec<String> = truths.iter().map(|t| t.recording.clone()).collect();
        let bar = progress("diagnosing", files.len());
        self.diagnose(&programs, &folders.blind, &files, &folders.diagnosed, None, &bar)?;
        bar.finish_and_clear();
        put(&folders.truth, &truth)?;

        if self.without {
            self.diagnose_without(&programs, &folders, &trials)?;
        }
        let bar = progress("recording afresh", trials.len());
        let cases: Result<Vec<Case>, CampaignError> = pool.install(|| {
            trials
                .into_par_iter()
                .map(|trial| {
                    let case = self.case(&programs, &folders, trial);
                    bar.inc(1);
                    case
                })
                .collect()
        });
        bar.finish_and_clear();
        Ok(Outcome { cases: cases?, sealed: hash })
    }

    /// Draws every trial and writes its recording under a name that says nothing.
    fn draw(&self, folders: &Folders) -> Result<Vec<Trial>, CampaignError> {
        let assignments = plan::assignments(self.trials, self.nulls, self.seed);
        let mut numbers: Vec<usize> = (0..assignments.len()).collect();
        let mut generator = ChaCha12Rng::seed_from_u64(self.seed);
        generator.set_stream(1);
        numbers.shuffle(&mut generator);
        let bar = progress("recording", assignments.len());
        let trials = assignments
            .par_iter()
            .zip(&numbers)
            .map(|(assignment, number)| {
                let trial = Trial::draw(assignment, format!("r{number:06}.csv"))?;
                twin::write_file(&trial.record(), &folders.blind.join(&trial.truth.recording))?;
                bar.inc(1);
                Ok(trial)
            })
            .collect();
        bar.finish_and_clear();
        trials
    }

    /// Has files diagnosed, a batch at a time. A batch that is refused is given again one by one, so that one
    /// bad recording costs one answer.
    fn diagnose(
        &self,
        programs: &Programs,
        blind: &Path,
        files: &[String],
        out: &Path,
        without: Option<&str>,
        bar: &ProgressBar,
    ) -> Result<(), CampaignError> {
        for batch in files.chunks(BATCH) {
            if programs.diagnose(blind, batch, out, without, self.jobs)?.is_err() {
                for file in batch {
                    let one = std::slice::from_ref(file);
                    if let Err(reason) = programs.diagnose(blind, one, out, without, self.jobs)? {
                        bar.suspend(|| eprintln!("{file} was refused: {reason}"));
                    }
                }
            }
            bar.inc(batch.len() as u64);
        }
        Ok(())
    }

    /// The strong single effects once more, each left out of the catalogue.
    fn diagnose_without(
        &self,
        programs: &Programs,
        folders: &Folders,
        trials: &[Trial],
    ) -> Result<(), CampaignError> {
        let strong = || trials.iter().filter(|t| t.truth.group == Group::Strong);
        let bar = progress("leaving out", strong().count());
        for formula in crate::formulas::FORMULAS {
            let mut files: Vec<String> = strong()
                .filter(|t| t.truth.effects[0].id == formula.id)
                .map(|t| t.truth.recording.clone())
                .collect();
            files.sort();
            self.diagnose(programs, &folders.blind, &files, &folders.without, Some(formula.id), &bar)?;
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Reads the answer to a trial and tries it on a fresh recording.
    fn case(&self, programs: &Programs, folders: &Folders, trial: Trial) -> Result<Case, CampaignError> {
        let stem = trial.truth.recording.trim_end_matches(".csv").to_owned();
        let answer = answer(&folders.diagnosed.join(format!("{stem}.json")))?;
        let without = match self.without && trial.truth.group == Group::Strong {
            true => Some(answer_of(&folders.without, &stem)?),
            false => None,
        };
        let compared =
            answer.is_some() && !matches!(trial.truth.group, Group::Null | Group::Ambiguous | Group::Outside);
        let mut fresh = None;
        if compared {
            let log = trial.record_fresh();
            let file = folders.fresh.join(format!("{stem}.csv"));
            let angles = folders.fresh.join(format!("{stem}.angles.csv"));
            twin::write_file(&log, &file)?;
            let coefficients = folders.diagnosed.join(format!("{stem}.coefficients.json"));
            match programs.apply(&file, &coefficients, &angles)? {
                Ok(()) => {
                    let covariance = trial.covariance();
                    let twice = Twice {
                        seen: &trial.record(),
                        fresh: &log,
                        ids: &trial.truth.ids(),
                        covariance: Some(&covariance),
                        distance_mm: trial.distance_mm(),
                    };
                    fresh = fresh::compare(&twice, &angles);
                }
                Err(reason) => eprintln!("{stem}: the coefficients were refused: {reason}"),
            }
        }
        Ok(Case { truth: trial.truth, answer, fresh, without })
    }

    fn folders(&self) -> Result<Folders, CampaignError> {
        // Absolute, since the programs are started in a folder of their own.
        let out = std::path::absolute(&self.out)
            .map_err(|e| CampaignError::Write { path: self.out.clone(), reason: e.kind() })?;
        let marker = out.join("campaign");
        let occupied = std::fs::read_dir(&out).is_ok_and(|mut entries| entries.next().is_some());
        if occupied && !marker.is_file() {
            return Err(CampaignError::Occupied { path: self.out.clone() });
        }
        let folders = Folders {
            blind: out.join("recordings"),
            diagnosed: out.join("diagnosed"),
            without: out.join("without"),
            fresh: out.join("fresh"),
            truth: out.join("truth.jsonl"),
        };
        for folder in [&folders.blind, &folders.diagnosed, &folders.without, &folders.fresh] {
            // An answer of an earlier campaign must never be taken for one of this.
            if folder.is_dir() {
                std::fs::remove_dir_all(folder)
                    .map_err(|e| CampaignError::Write { path: folder.clone(), reason: e.kind() })?;
            }
            std::fs::create_dir_all(folder)
                .map_err(|e| CampaignError::Write { path: folder.clone(), reason: e.kind() })?;
        }
        put(&marker, "Written by trials; its folders are overwritten by the next campaign.\n")?;
        put(&folders.blind.join("mirror.toml"), MIRROR)?;
        Ok(folders)
    }
}

/// The answer with a stem in a folder; none where it was refused.
fn answer_of(folder: &Path, stem: &str) -> Result<Option<Answer>, AnswerError> {
    answer(&folder.join(format!("{stem}.json")))
}

fn answer(path: &Path) -> Result<Option<Answer>, AnswerError> {
    if path.is_file() { Answer::read(path).map(Some) } else { Ok(None) }
}

/// Writes a whole file.
pub fn put(path: &Path, text: &str) -> Result<(), CampaignError> {
    fitter::output::write_whole(path, |file| file.write_all(text.as_bytes())).map_err(|_| {
        CampaignError::Write { path: path.to_owned(), reason: std::io::ErrorKind::PermissionDenied }
    })
}

/// A progress bar on standard error, if someone is watching.
fn progress(what: &str, count: usize) -> ProgressBar {
    // Hidden by itself where standard error is no terminal.
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg:17} {bar:40} {pos}/{len}, {eta} left") {
        bar.set_style(style);
    }
    bar.with_message(what.to_owned())
}
