//! One dynamic campaign: draw, write the recordings, seal, have them diagnosed blind, unseal, score.

use std::path::Path;

use twin::dynamic::{Series, bench};
use twin::log::write_series;

use super::draw::Trial;
use super::plan;
use super::score::Case;
use super::truth::Truth;
use crate::error::CampaignError;
use crate::programs::{Nominal, Programs};
use crate::workspace::{Batches, Campaign, Folders, Outcome, answer_of, diagnose_sealed, draw_all, threads};

/// What is stated to the programs of the plant: nothing but its kind and units.
const PLANT: &str = include_str!("plant.toml");
/// The first rows of a run give its initial state and are not scored.
const INITIAL_ROWS: usize = 50;

impl Campaign<usize> {
    /// Runs it; `sealed` is called with the hash of the truth before anything is diagnosed.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn run(
        &self,
        programs: &Programs,
        sealed: impl FnOnce(&str, usize),
    ) -> Result<Outcome<Case>, CampaignError> {
        let folders = Folders::prepare(&self.out, Nominal::Plant, PLANT)?;
        let pool = threads(self.jobs)?;
        let mut truths = pool.install(|| self.draw(programs, &folders))?;
        truths.sort_by(|a, b| a.recording.cmp(&b.recording));
        let batches = Batches { programs, nominal: Nominal::Plant, jobs: self.jobs };
        let listed: Vec<(&str, &Truth)> = truths.iter().map(|t| (t.recording.as_str(), t)).collect();
        let sealed = diagnose_sealed(&batches, &folders, &listed, sealed)?;
        let cases = truths
            .into_iter()
            .map(|truth| case(truth, &folders.blind, &folders.diagnosed))
            .collect::<Result<_, _>>()?;
        Ok(Outcome { cases, sealed })
    }

    /// Draws every trial and writes its recording under a name that says nothing.
    fn draw(&self, programs: &Programs, folders: &Folders) -> Result<Vec<Truth>, CampaignError> {
        draw_all(programs, self.seed, &plan::assignments(self.counts, self.seed), |assignment, number| {
            let trial = Trial::draw(assignment, &format!("r{number:06}.csv.gz"))?;
            let file = folders.blind.join(&trial.truth.recording);
            write_series(&trial.series, Some(bench::DECIMALS), &file)?;
            Ok(trial.truth)
        })
    }
}

/// Reads the answer to a trial, and what its free run leaves.
pub(super) fn case(truth: Truth, blind: &Path, diagnosed: &Path) -> Result<Case, CampaignError> {
    let stem = truth.recording.trim_end_matches(".gz").trim_end_matches(".csv");
    let answer = answer_of(diagnosed, stem)?;
    let left = match answer {
        Some(_) => left(&blind.join(&truth.recording), &diagnosed.join(format!("{stem}.simulated.csv"))),
        None => None,
    };
    Ok(Case { truth, answer, left })
}

/// Root mean square of the recorded position less the augmented plant's free run, over the rows that are
/// scored; none where the simulation does not hold a row for each of the recording's.
fn left(recording: &Path, simulated: &Path) -> Option<f64> {
    let series = Series::read(recording).ok()?;
    let text = std::fs::read_to_string(simulated).ok()?;
    let mut lines = text.lines();
    let column = lines.next()?.split(',').position(|name| name.trim() == "after")?;
    let after: Vec<f64> =
        lines.map(|line| line.split(',').nth(column)?.trim().parse().ok()).collect::<Option<_>>()?;
    let position = series.positions.first()?;
    if after.len() != position.len() {
        return None;
    }
    let skipped = if series.period.is_some() { 0 } else { INITIAL_ROWS };
    let (mut square, mut count) = (0.0, 0.0);
    for rows in series.runs() {
        for row in rows.start + skipped.min(rows.len())..rows.end {
            square += (position[row] - after[row]).powi(2);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| (square / count).sqrt())
}
