//! What any campaign does with folders and programs: a place to write, recordings diagnosed batch by batch in
//! a folder that holds nothing else, answers read.

use std::path::{Path, PathBuf};

use rand::seq::SliceRandom;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde::Serialize;

use crate::answer::Answer;
use crate::error::CampaignError;
use crate::programs::{Nominal, Programs};
use crate::truth::seal;

/// Recordings given to one call of `diagnose`.
const BATCH: usize = 40;

/// Makes of what the system said the refusal of a folder that cannot be written.
pub(crate) fn unwritable(path: &Path) -> impl Fn(std::io::Error) -> CampaignError + use<> {
    let path = path.to_owned();
    move |error| CampaignError::Write { path: path.clone(), reason: error.kind() }
}

/// Makes a folder anew: an answer of an earlier campaign must never be taken for one of this.
pub(crate) fn empty_folder(folder: &Path) -> Result<(), CampaignError> {
    if folder.is_dir() {
        std::fs::remove_dir_all(folder).map_err(unwritable(folder))?;
    }
    std::fs::create_dir_all(folder).map_err(unwritable(folder))
}

/// The first of so many draws from a seed that succeeds.
///
/// # Errors
/// [`CampaignError::Undrawn`], which names the `group` of the trial.
pub(crate) fn first_draw<T>(
    tries: u32,
    seed: u64,
    group: impl std::fmt::Debug,
    draw: impl Fn(&mut ChaCha12Rng) -> Option<T>,
) -> Result<T, CampaignError> {
    let attempt = |attempt: u32| {
        let mut generator = ChaCha12Rng::seed_from_u64(seed);
        generator.set_stream(u64::from(attempt));
        draw(&mut generator)
    };
    (0..tries).find_map(attempt).ok_or_else(|| CampaignError::Undrawn {
        group: format!("{group:?}"),
        seed,
        tries,
    })
}

/// Draws every trial of a campaign, and records it, by `draw`, which is given a number that says nothing of the trial.
pub(crate) fn draw_all<A: Sync, T: Send>(
    programs: &Programs,
    seed: u64,
    assignments: &[A],
    draw: impl Fn(&A, usize) -> Result<T, CampaignError> + Sync,
) -> Result<Vec<T>, CampaignError> {
    let mut numbers: Vec<usize> = (0..assignments.len()).collect();
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    generator.set_stream(1);
    numbers.shuffle(&mut generator);
    programs.begin("recording", assignments.len());
    let drawn = assignments.par_iter().zip(&numbers).map(|(assignment, number)| {
        let trial = draw(assignment, *number)?;
        programs.watch.advance(1);
        Ok(trial)
    });
    drawn.collect()
}

/// What a campaign is asked for.
#[derive(Debug, Clone)]
pub struct Campaign<C> {
    /// How many trials of what.
    pub counts: C,
    /// Seed of everything.
    pub seed: u64,
    /// Threads.
    pub jobs: usize,
    /// The folder that everything is written into: the recordings stay there.
    pub out: PathBuf,
}

/// What becomes of every trial as `case` tries it on a fresh recording.
pub(crate) fn afresh<T: Send, C: Send>(
    programs: &Programs,
    pool: &rayon::ThreadPool,
    trials: Vec<T>,
    case: impl Fn(T) -> Result<C, CampaignError> + Sync,
) -> Result<Vec<C>, CampaignError> {
    programs.begin("recording afresh", trials.len());
    let advancing = |trial: T| {
        let case = case(trial);
        programs.watch.advance(1);
        case
    };
    pool.install(|| trials.into_par_iter().map(advancing).collect())
}

/// What a campaign brought.
pub struct Outcome<C> {
    /// The trials, unsealed.
    pub cases: Vec<C>,
    /// SHA-256 of the sealed truth.
    pub sealed: String,
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
        // Absolute, since the programs are started in a folder of their own.
        let full = std::path::absolute(out).map_err(unwritable(out))?;
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
            empty_folder(folder)?;
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
    /// [`CampaignError`].
    pub fn diagnose(
        &self,
        blind: &Path,
        files: &[String],
        out: &Path,
        without: Option<&str>,
    ) -> Result<(), CampaignError> {
        let options = without.map_or_else(Vec::new, |id| vec!["--without", id]);
        let run =
            |files: &[String]| self.programs.diagnose(self.nominal, blind, files, out, &options, self.jobs);
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
/// [`CampaignError`] where it is of another form.
pub(crate) fn answer_of(folder: &Path, stem: &str) -> Result<Option<Answer>, CampaignError> {
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
