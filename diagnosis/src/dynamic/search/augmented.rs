//! What a search asks of a model that effects can be added to.

use super::Search;
use crate::dynamic::data::{Data, FIT_ROWS, Folds};
use crate::dynamic::estimate::{Fitted, Simulated, fit_in};
use crate::thresholds::dynamic::search::contenders::HEAT;

/// See the module.
pub trait Augmented: Simulated {
    /// An effect that may be named.
    type Effect: Clone + Send + Sync;
    /// An effect with its parameters.
    type Term: Clone + Send + Sync;

    /// Number of further effects that are refitted in every round for what they explain before whitening.
    fn refitted_plainly() -> usize;

    /// The effects of the model.
    fn terms(&self) -> &[Self::Term];

    /// The effect of a term.
    fn effect(term: &Self::Term) -> &Self::Effect;

    /// The id of an effect.
    fn id(effect: &Self::Effect) -> &str;

    /// Whether an effect is easily taken for another.
    fn confused(effect: &Self::Effect, other: &Self::Effect) -> bool;

    /// An effect that a search tries only where this other one, to which it is equal to first order, helps.
    fn follows(_: &Self::Effect) -> Option<&'static str> {
        None
    }

    /// Terms from which a search of an effect starts; what multiplies it is zero.
    fn starts(effect: &Self::Effect, data: &Data) -> Vec<Self::Term>;

    /// Whether a term's parameters can be its effect.
    fn sound(term: &Self::Term, data: &Data) -> bool;

    /// Number of parameters that multiply a term's effect where they are all zero, so that it can be screened.
    fn amounts(term: &Self::Term) -> usize;

    /// Number of states that a term adds.
    fn states(term: &Self::Term) -> usize;

    /// The term as it is screened: only its amounts are free.
    fn probed(term: &Self::Term) -> Self::Term;

    /// The model with one more term; none where it cannot hold that.
    fn with(&self, term: Self::Term) -> Option<Self>;

    /// The model without its term `k`.
    fn without(&self, k: usize) -> Option<Self>;

    /// The model fitted to the wanted kinds of rows.
    fn fitted(&self, states: &[Self::Start], data: &Data, folds: Folds) -> Option<Fitted<Self>>;

    /// The first steps of an estimate on the rows that fit; the last term is new.
    fn begun(&self, states: &[Self::Start], data: &Data) -> Option<Fitted<Self>> {
        fit_in(HEAT, self, states, data, FIT_ROWS)
    }

    /// A contender that was compared after a few steps, followed to the end.
    fn finished(search: &Search<Self>, fitted: Fitted<Self>) -> Option<Fitted<Self>>;

    /// Models with an effect of the catalogue in the place of term `k`, begun from what that is.
    fn replaced(_: &Search<Self>, _: &Fitted<Self>, _k: usize) -> Vec<Self> {
        Vec::new()
    }

    /// Further models beside an estimate that are fitted in full, given the terms that were tried beside it.
    fn further(_: &Search<Self>, _: &Fitted<Self>, _: &[Self::Term]) -> Vec<Self> {
        Vec::new()
    }

    /// Whether the last effect of `after` is worth its parameters beside `before`.
    fn worth(search: &Search<Self>, before: &Fitted<Self>, after: &Fitted<Self>) -> bool {
        super::worth(search.data, before, after)
    }

    /// Whether the model has an effect.
    fn has(&self, id: &str) -> bool {
        self.terms().iter().any(|term| Self::id(Self::effect(term)) == id)
    }
}
