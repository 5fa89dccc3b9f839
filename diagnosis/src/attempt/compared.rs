//! Which of two explanations of a recording is to be preferred. Held-out figures are compared over the same groups: blocks are
//! easier to predict than passes.

use super::Attempt;
use crate::explain::Explanation;
use crate::hand_on::HandOn;
use crate::held_out::{self, Choice, Groups, Shown, gain};
use crate::search::Term;
use crate::thresholds::NO_WORSE;
use crate::thresholds::compose::{CLEARLY, OVERFITTED};

impl Attempt<'_> {
    /// Whether an attempt with forms is to be preferred to this one of named effects alone.
    ///
    /// - Where the names leave structure, forms must leave less. Forms that are not handed on may instead describe everything: with
    ///   a clearly greater merit where there are names, with any where there are none.
    /// - Where the names explain everything, forms need a clearly greater merit. If such forms leave structure, they must also leave
    ///   less of held-out readings and be no more than the names, if there are any: two effects that explain everything are not
    ///   given up for five that do not.
    pub(super) fn gives_way_to(&self, with_forms: &Attempt, hand_on: &HandOn) -> bool {
        if self.leaves_structure() {
            // Where other recordings get nothing of the forms, their held-out figures are those of the base alone.
            let describes_all = with_forms.explains_all && !with_forms.hands_on();
            let says_more =
                || self.said.effects.is_empty() || self.has_less_merit_than(&with_forms.explanation);
            return (describes_all && says_more()) || self.leaves_more_than(with_forms, hand_on);
        }
        let (own, of_forms) = (&self.said.effects, &with_forms.said.effects);
        let as_short = own.is_empty() || of_forms.len() <= own.len();
        let does_better = || as_short && self.leaves_more_held_out(with_forms, hand_on);
        self.has_less_merit_than(&with_forms.explanation) && (with_forms.explains_all || does_better())
    }

    /// Whether a curve of this attempt counts beside another one: the search without the held-out rows chose it, and it predicts
    /// them better than the base and better than the other, beyond the intervals of both gains.
    pub(super) fn is_chosen_over(&self, other: &Attempt, hand_on: &HandOn) -> bool {
        let shown = self.settled.shown.as_ref().filter(|shown| shown.chosen_without);
        shown.is_some_and(|shown| self.is_shown_by(shown))
            && other.is_fitted_by(self)
            && self.predicts_surely_better_than(other, hand_on)
    }

    /// Whether whole passes show it. Between blocks a curve that follows slowly does as well as any slow function of the time.
    pub(super) fn is_shown_by_passes(&self, hand_on: &HandOn) -> bool {
        self.shown_by("pass", hand_on).is_some_and(|shown| self.is_shown_by(&shown))
    }

    /// Whether the terms of an attempt with forms are clearly likelier, for what is asked of each.
    pub(super) fn has_less_merit_than(&self, with_forms: &Explanation) -> bool {
        let (search, terms) = (&with_forms.search, &with_forms.terms);
        let own = search.translated(&self.explanation.search, &self.explanation.terms);
        search.merit(terms) > search.merit(&own) + CLEARLY
    }

    /// Whether another attempt leaves less of held-out readings, and no more of fitted ones.
    fn leaves_more_than(&self, other: &Attempt, hand_on: &HandOn) -> bool {
        self.is_fitted_by(other) && self.leaves_more_held_out(other, hand_on)
    }

    /// Whether another attempt leaves no more of fitted readings.
    fn is_fitted_by(&self, other: &Attempt) -> bool {
        other.fit.after.train_rms <= NO_WORSE * self.fit.after.train_rms
    }

    fn leaves_more_held_out(&self, other: &Attempt, hand_on: &HandOn) -> bool {
        match self.shown_with(other, hand_on) {
            Some((own, of_other)) => of_other.rms < own.rms,
            None => other.left() < self.left(),
        }
    }

    /// Whether held-out rows are predicted better, beyond the interval of the gain, and not much worse than those that were fitted.
    fn is_shown_by(&self, shown: &Shown) -> bool {
        gain(&shown.gains).is_certain() && shown.rms < OVERFITTED * self.fit.after.train_rms
    }

    /// Whether it predicts held-out groups better than another attempt, beyond the interval of the difference. One of which other
    /// recordings get nothing must only leave more.
    fn predicts_surely_better_than(&self, other: &Attempt, hand_on: &HandOn) -> bool {
        if !other.hands_on() {
            return other.leaves_more_held_out(self, hand_on);
        }
        self.shown_with(other, hand_on).is_some_and(|(own, of_other)| {
            let pairs = own.gains.iter().zip(&of_other.gains);
            gain(&pairs.map(|(own, other)| own - other).collect::<Vec<f64>>()).is_certain()
        })
    }

    /// Whether other recordings get something.
    fn hands_on(&self) -> bool {
        let catalogue = self.explanation.search.catalogue;
        let terms = &self.settled.handed.terms;
        terms.iter().filter_map(|term| term.effect).any(|effect| !catalogue[effect].of_one_time)
    }

    /// What this attempt and another show of the same held-out groups: of blocks where either was judged by them, since what
    /// happened at one time shows in nothing else.
    fn shown_with(&self, other: &Attempt, hand_on: &HandOn) -> Option<(Shown, Shown)> {
        let by = if other.fit.held_out_by == "block" { "block" } else { &self.fit.held_out_by };
        self.shown_by(by, hand_on).zip(other.shown_by(by, hand_on))
    }

    fn shown_by(&self, groups: &str, hand_on: &HandOn) -> Option<Shown> {
        let shown = self.settled.shown.as_ref()?;
        if self.fit.held_out_by == groups {
            return Some(shown.clone());
        }
        let wanted = if groups == "block" { Groups::Blocks } else { Groups::Passes };
        let hand_on = HandOn { catalogue: self.explanation.search.catalogue, ..*hand_on };
        let proof = held_out::prove(&self.explanation, &hand_on, &self.before, wanted)?;
        let handed = &self.settled.handed;
        let terms: Vec<Term> = handed.terms.iter().map(|term| term.term.clone()).collect();
        if terms.is_empty() {
            return Some(Shown { rms: proof.before(), ..shown.clone() });
        }
        let choice = if shown.chosen_without { Choice::Searched } else { Choice::Of(&terms) };
        proof.shows(&hand_on, &choice, handed.order)
    }

    /// What is left of held-out readings, of all where none are held out.
    pub(super) fn left(&self) -> f64 {
        self.fit.after.held_out_rms.unwrap_or(self.fit.after.train_rms)
    }
}
