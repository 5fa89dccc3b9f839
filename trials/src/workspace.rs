//! What any campaign does with folders and programs: a place to write, recordings diagnosed batch by batch in
//! a folder that holds nothing else, answers read.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::answer::{Answer, AnswerError};
use crate::draw::Undrawn;
use crate::programs::{Nominal, ProgramError, Programs};
use crate::truth::seal;

/// Recordings given to one call of `diagnose`.
const BATCH: usize = 40;

/// Why a campaign ended early.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A program could not be run.
    #[error(transparent)]
    Program(#[from] ProgramError),
    /// A trial could not be drawn.
    #[error(transparent)]
    Undrawn(#[from] Undrawn),
    /// A moving mechanism could not be simulated.
    #[error(transparent)]
    Motion(#[from] twin::dynamic::RunError),
    /// No moving mechanism of the wanted kind could be drawn.
    #[error(transparent)]
    UndrawnMotion(#[from] crate::dynamic::draw::Undrawn),
    /// A recording could not be written.
    #[error(transparent)]
    Recording(#[from] twin::log::WriteError),
    /// An answer is missing or of another form.
    #[error(transparent)]
    Answer(#[from] AnswerError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] fitter::output::OutputError),
    /// A folder could not be made.
    #[error("{}: cannot be written ({reason}); give --out a folder that can be written", .path.display())]
    Write {
        /// The folder.
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

/// The folders of a campaign.
pub struct Folders {
    /// The recordings, and what is stated of the device to the programs; nothing else.
    pub blind: PathBuf,
    /// The answers.
    pub diagnosed: PathBuf,
    /// The answers with an effect left out of the catalogue.
    pub without: PathBuf,
    /// Fresh recordings.
    pub fresh: PathBuf,
    /// The truth, unsealed.
    pub truth: PathBuf,
}

impl Folders {
    /// Makes them anew in `out`, with what is stated of the device to the programs.
    ///
    /// # Errors
    /// [`CampaignError::Occupied`], [`CampaignError::Write`].
    pub fn prepare(out: &Path, nominal: Nominal, stated: &str) -> Result<Self, CampaignError> {
        let write =
            |path: &Path, e: std::io::Error| CampaignError::Write { path: path.to_owned(), reason: e.kind() };
        // Absolute, since the programs are started in a folder of their own.
        let full = std::path::absolute(out).map_err(|e| write(out, e))?;
        let marker = full.join("campaign");
        let occupied = std::fs::read_dir(&full).is_ok_and(|mut entries| entries.next().is_some());
        if occupied && !marker.is_file() {
            return Err(CampaignError::Occupied { path: out.to_owned() });
        }
        let folders = Self {
            blind: full.join("recordings"),
            diagnosed: full.join("diagnosed"),
            without: full.join("without"),
            fresh: full.join("fresh"),
            truth: full.join("truth.jsonl"),
        };
        for folder in [&folders.blind, &folders.diagnosed, &folders.without, &folders.fresh] {
            // An answer of an earlier campaign must never be taken for one of this.
            if folder.is_dir() {
                std::fs::remove_dir_all(folder).map_err(|e| write(folder, e))?;
            }
            std::fs::create_dir_all(folder).map_err(|e| write(folder, e))?;
        }
        put(&marker, "Written by trials; its folders are overwritten by the next campaign.\n")?;
        put(&folders.blind.join(nominal.file()), stated)?;
        Ok(folders)
    }
}

/// How recordings are diagnosed.
pub struct Batches<'a> {
    /// The programs.
    pub programs: &'a Programs<'a>,
    /// What is stated of the device to them.
    pub nominal: Nominal,
    /// Threads.
    pub jobs: usize,
}

impl Batches<'_> {
    /// Has files diagnosed, a batch at a time. A batch that is refused is given again one by one, so that one
    /// bad recording costs one answer.
    ///
    /// # Errors
    /// [`ProgramError`].
    pub fn diagnose(
        &self,
        blind: &Path,
        files: &[String],
        out: &Path,
        without: Option<&str>,
    ) -> Result<(), ProgramError> {
        let run =
            |files: &[String]| self.programs.diagnose(self.nominal, blind, files, out, without, self.jobs);
        for batch in files.chunks(BATCH) {
            if run(batch)?.is_err() {
                for file in batch {
                    if let Err(reason) = run(std::slice::from_ref(file))? {
                        self.programs.watch.warn(&format!("{file} was refused: {reason}"));
                    }
                }
            }
            self.programs.watch.advance(batch.len() as u64);
        }
        Ok(())
    }
}

/// Seals what was concealed, says the hash and the number of recordings, has the recordings diagnosed blind, and
/// only then writes the truth. The truths are sorted by their recordings; the hash.
///
/// # Errors
/// [`CampaignError`].
pub fn diagnose_sealed<T: Serialize>(
    batches: &Batches,
    folders: &Folders,
    truths: &[(&str, &T)],
    sealed: impl FnOnce(&str, usize),
) -> Result<String, CampaignError> {
    let (truth, hash) = seal(&truths.iter().map(|(_, truth)| *truth).collect::<Vec<_>>());
    sealed(&hash, truths.len());
    let files: Vec<String> = truths.iter().map(|(file, _)| (*file).to_owned()).collect();
    batches.programs.begin("diagnosing", files.len());
    batches.diagnose(&folders.blind, &files, &folders.diagnosed, None)?;
    put(&folders.truth, &truth)?;
    Ok(hash)
}

/// So many threads.
///
/// # Errors
/// [`CampaignError::Threads`].
pub fn threads(jobs: usize) -> Result<rayon::ThreadPool, CampaignError> {
    rayon::ThreadPoolBuilder::new().num_threads(jobs).build().map_err(|_| CampaignError::Threads(jobs))
}

/// The answer with a stem in a folder; none where it was refused.
///
/// # Errors
/// [`AnswerError`] where it is of another form.
pub fn answer_of(folder: &Path, stem: &str) -> Result<Option<Answer>, AnswerError> {
    let path = folder.join(format!("{stem}.json"));
    if path.is_file() { Answer::read(&path).map(Some) } else { Ok(None) }
}

/// Writes a whole file.
///
/// # Errors
/// [`CampaignError::Output`].
pub fn put(path: &Path, text: &str) -> Result<(), CampaignError> {
    Ok(fitter::output::write_whole(path, |file| file.write_all(text.as_bytes()))?)
}
