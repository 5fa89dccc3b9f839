//! Terms in whose place another effect does nearly as well here and says something else of other recordings. What is handed on
//! is the mean of the models with either, each as far as it is likely (Bayesian model averaging, as in [`crate::averaging`]):
//! of all that could be handed on it leaves least of another recording in the mean, and never more than the worse of both.

use fitter::Coefficients;
use numerics::rms;

use crate::ambiguity::{Conflict, conflicts};
use crate::held_out::{Choice, Groups, Shown, prove};
use crate::judge::{Handed, Judge, same};
use crate::model::{Model, predictive};
use crate::search::Term;
use crate::thresholds::NO_WORSE;

/// A model in the mean that is handed on.
pub struct Weighted {
    /// Its part in the mean.
    pub weight: f64,
    /// Its coefficients.
    pub file: Coefficients,
}

/// What no recording like this one decides.
pub struct Undecided {
    /// A sentence each.
    pub said: Vec<String>,
    /// Models with another effect in the place of a term.
    pub instead: Vec<Instead>,
}

/// A model with another effect in the place of a term.
pub struct Instead {
    /// How likely it is beside the model as found.
    odds: f64,
    file: Coefficients,
    /// What it leaves of every reading.
    left: Vec<f64>,
    shown: Option<Shown>,
}

impl<'a> Judge<'a, '_> {
    /// The models with another effect in the place of one of these terms. A term is left out where such a model could not be
    /// handed on.
    pub fn undecided(&self, kept: &mut Vec<Term>, joint: &Model) -> Undecided {
        let mut conflicts = self.conflicts_of(kept, joint);
        let mut said = Vec::new();
        loop {
            let all: Vec<Option<Instead>> =
                conflicts.iter().map(|conflict| self.instead(conflict, kept, joint.order)).collect();
            if let Some(at) = all.iter().position(Option::is_none) {
                let conflict = conflicts.remove(at);
                said.push(self.sentence(&conflict, "nothing of it is handed on to them"));
                kept.retain(|term| !same(term, &conflict.term));
                continue;
            }
            let instead: Vec<Instead> = all.into_iter().flatten().collect();
            let whole = whole(&instead);
            said.extend(conflicts.iter().zip(&instead).map(|(conflict, instead)| {
                let part = 100.0 * instead.odds / whole;
                let of = [self.id(&conflict.term), &self.catalogue[conflict.effect].id];
                let own = 100.0 - part;
                let mean =
                    format!("their mean is handed on: {own:.0} % of {}, {part:.0} % of {}", of[0], of[1]);
                self.sentence(conflict, &mean)
            }));
            return Undecided { said, instead };
        }
    }

    /// The conflicts of these terms, one each.
    fn conflicts_of(&self, kept: &[Term], joint: &Model) -> Vec<Conflict<'_, 'a>> {
        let searched = [Some(self.explanation), self.with_forms].into_iter().flatten();
        let found = searched.flat_map(|s| conflicts(self.explanation, self.catalogue, joint, s));
        found.fold(Vec::new(), |mut first: Vec<Conflict>, conflict| {
            let known = first.iter().any(|other| same(&other.term, &conflict.term));
            if !known && kept.iter().any(|term| same(term, &conflict.term)) {
                first.push(conflict);
            }
            first
        })
    }

    fn sentence(&self, conflict: &Conflict, what: &str) -> String {
        let rival = &self.catalogue[conflict.effect];
        format!(
            "{}: whether it is that or {} ({}), which does nearly as well here and predicts something else for other \
             recordings; {what}",
            self.id(&conflict.term),
            rival.id,
            rival.title
        )
    }

    /// The model with the other effect; none where it could not be handed on.
    fn instead(&self, conflict: &Conflict<'_, 'a>, kept: &[Term], order: usize) -> Option<Instead> {
        let Conflict { term, rival, odds, searched, .. } = conflict;
        let others: Vec<Term> = kept.iter().filter(|other| !same(other, term)).cloned().collect();
        let mut terms = searched.search.translated(&self.explanation.search, &others);
        if terms.len() < others.len() || self.hand_on.simulated {
            return None;
        }
        terms.push(rival.clone());
        let model = predictive(searched, &terms, order);
        let refitted = self.hand_on.refitted(&model, None);
        let left = self.hand_on.left_by(Some(&refitted), &model, None)?;
        let shown = match self.proof_of(kept) {
            None => None,
            Some(own) => {
                let groups = if own.by() == "block" { Groups::Blocks } else { Groups::Passes };
                let proof = prove(searched, self.hand_on, self.before, groups)?;
                let shown = proof.shows(self.hand_on, &Choice::Of(&terms), order)?;
                if shown.rms > NO_WORSE * proof.before() {
                    return None;
                }
                Some(shown)
            }
        };
        let no_worse = rms(&left) <= NO_WORSE * rms(self.before_left);
        let file = self.hand_on.file(&refitted, &model).ok().filter(|_| no_worse)?;
        Some(Instead { odds: *odds, file, left, shown })
    }

    /// The mean of a model as found and those with another effect. Of held-out rows it leaves no more than the mean of what they
    /// leave: the triangle inequality.
    pub fn mean(&self, found: Handed, instead: Vec<Instead>) -> (Handed, Vec<Weighted>) {
        if instead.is_empty() {
            return (found, Vec::new());
        }
        let whole = whole(&instead);
        let Handed { model, refitted, mut left, shown } = found;
        left.iter_mut().for_each(|left| *left /= whole);
        let mut shown = shown.map(|shown| scaled(shown, 1.0 / whole));
        let mut weighted = Vec::new();
        for Instead { odds, file, left: own, shown: own_shown } in instead {
            let weight = odds / whole;
            left.iter_mut().zip(&own).for_each(|(left, own)| *left += weight * own);
            shown = shown.zip(own_shown).map(|(sum, own)| sum_of(sum, scaled(own, weight)));
            weighted.push(Weighted { weight, file });
        }
        (Handed { model, refitted, left, shown }, weighted)
    }
}

/// The odds of all models together, those of the model as found being 1.
fn whole(instead: &[Instead]) -> f64 {
    1.0 + instead.iter().map(|instead| instead.odds).sum::<f64>()
}

fn scaled(shown: Shown, by: f64) -> Shown {
    let gains = shown.gains.iter().map(|gain| by * gain).collect();
    Shown { rms: by * shown.rms, gains, ..shown }
}

fn sum_of(a: Shown, b: Shown) -> Shown {
    let gains = a.gains.iter().zip(&b.gains).map(|(a, b)| a + b).collect();
    Shown { rms: a.rms + b.rms, gains, chosen_without: a.chosen_without && b.chosen_without }
}
