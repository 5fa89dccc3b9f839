//! One campaign: draw, write the recordings, seal, have them diagnosed blind, unseal, compare on fresh
//! recordings.

use twin::Reading;

use crate::answer::Answer;
use crate::benchmark;
use crate::draw::Trial;
use crate::error::CampaignError;
use crate::fresh::{self, Fresh, Twice};
use crate::linear::deviation;
use crate::plan::{self, Counts};
use crate::programs::{Nominal, Programs};
use crate::score::Case;
use crate::truth::{Group, Truth};
use crate::workspace::{
    Batches, Campaign, Folders, Outcome, afresh, answer_of, diagnose_sealed, draw_all, threads,
};

/// What is stated to the programs of the mirror: the paper's, which all devices are built as.
const MIRROR: &str = include_str!("mirror.toml");

impl Campaign<Counts> {
    /// Runs it; `sealed` is called with the hash of the truth before anything is diagnosed.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn run(
        &self,
        programs: &Programs,
        sealed: impl FnOnce(&str, usize),
    ) -> Result<Outcome<Case>, CampaignError> {
        let folders = Folders::prepare(&self.out, Nominal::Mirror, MIRROR)?;
        let pool = threads(self.jobs)?;
        let trials = pool.install(|| self.draw(programs, &folders))?;
        let mut truths: Vec<&Truth> = trials.iter().map(|t| &t.truth).collect();
        truths.sort_by(|a, b| a.recording.cmp(&b.recording));
        let batches = Batches { programs, nominal: Nominal::Mirror, jobs: self.jobs };
        let listed: Vec<(&str, &Truth)> = truths.into_iter().map(|t| (t.recording.as_str(), t)).collect();
        let sealed = diagnose_sealed(&batches, &folders, &listed, sealed)?;

        if self.counts.without {
            self.diagnose_without(&batches, &folders, &trials)?;
        }
        let cases = afresh(programs, &pool, trials, |trial| self.case(programs, &folders, trial))?;
        Ok(Outcome { cases, sealed })
    }

    /// Draws every trial and writes its recording under a name that says nothing.
    fn draw(&self, programs: &Programs, folders: &Folders) -> Result<Vec<Trial>, CampaignError> {
        draw_all(programs, self.seed, &plan::assignments(&self.counts, self.seed), |assignment, number| {
            let trial = Trial::draw(assignment, format!("r{number:06}.csv"))?;
            twin::write_file(&trial.record(), &folders.blind.join(&trial.truth.recording))?;
            Ok(trial)
        })
    }

    /// The strong single effects once more, each left out of the catalogue.
    fn diagnose_without(
        &self,
        batches: &Batches,
        folders: &Folders,
        trials: &[Trial],
    ) -> Result<(), CampaignError> {
        let strong = || trials.iter().filter(|t| t.truth.group == Group::Strong);
        batches.programs.begin("leaving out", strong().count());
        for formula in crate::formulas::FORMULAS {
            let mut files: Vec<String> = strong()
                .filter(|t| t.truth.effects[0].id == formula.id)
                .map(|t| t.truth.recording.clone())
                .collect();
            files.sort();
            batches.diagnose(&folders.blind, &files, &folders.without, Some(formula.id))?;
        }
        Ok(())
    }

    /// Reads the answer to a trial and tries it on a fresh recording.
    fn case(&self, programs: &Programs, folders: &Folders, trial: Trial) -> Result<Case, CampaignError> {
        let stem = trial.truth.recording.trim_end_matches(".csv").to_owned();
        let answer = answer_of(&folders.diagnosed, &stem)?;
        let without = match self.counts.without && trial.truth.group == Group::Strong {
            true => Some(answer_of(&folders.without, &stem)?),
            false => None,
        };
        let compared = answer.is_some()
            && !matches!(
                trial.truth.group,
                Group::Null | Group::Ambiguous | Group::Outside | Group::Interval
            );
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
                    if trial.truth.group == Group::Twice {
                        let fit_arcsec = base_alone(programs, folders, &stem, &log)?;
                        fresh = fresh.map(|fresh| Fresh { fit_arcsec, ..fresh });
                    }
                }
                Err(reason) => {
                    programs.watch.warn(&format!("{stem}: the coefficients were refused: {reason}"))
                }
            }
        }
        let named = |answer: Option<&Answer>| {
            let ids = answer?.ids();
            if ids.is_empty() { None } else { trial.left_by(&ids) }
        };
        let left_by_names = [
            if trial.truth.group == Group::Outside { named(answer.as_ref()) } else { None },
            named(without.as_ref().and_then(Option::as_ref)),
        ];
        let faint = matches!(trial.truth.group, Group::Weak | Group::Strong | Group::Step)
            && trial.truth.least_rho() < benchmark::FAINT;
        let benchmark = if faint { trial.benchmark() } else { None };
        Ok(Case { truth: trial.truth, answer, fresh, without, left_by_names, benchmark })
    }
}

/// Error on a fresh recording of the base model alone, as `fit` makes it from the first; none where it is
/// refused.
fn base_alone(
    programs: &Programs,
    folders: &Folders,
    stem: &str,
    log: &[Reading],
) -> Result<Option<f64>, CampaignError> {
    let coefficients = folders.fresh.join(format!("{stem}.base.json"));
    let angles = folders.fresh.join(format!("{stem}.base.csv"));
    let fitted = programs.fit(&folders.blind, &format!("{stem}.csv"), &coefficients)?;
    let applied = match fitted {
        Ok(()) => programs.apply(&folders.fresh.join(format!("{stem}.csv")), &coefficients, &angles)?,
        refused => refused,
    };
    match applied {
        Ok(()) => Ok(fresh::errors(&angles, log).map(|(error, _)| deviation(&error))),
        Err(reason) => {
            programs.watch.warn(&format!("{stem}: the base alone was refused: {reason}"));
            Ok(None)
        }
    }
}
