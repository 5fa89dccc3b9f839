//! Whether one named effect explains a recording so clearly that no form without a name can take its place. Then forms
//! are not searched, which takes nearly as long as everything before.

use crate::ambiguity::cost;
use crate::attempt::Attempt;
use crate::effects::Effect;
use crate::explain::Outset;
use crate::search::{Search, Term};
use crate::thresholds::alone::MORE_CORRELATED;
use crate::thresholds::ambiguity::CONTAINED;
use crate::thresholds::search::remainder::MISFIT;
use crate::thresholds::verdict::ALTERNATIVE_MARGIN;
use crate::verdict::Verdict;

/// Whether an attempt without forms is one effect that explains everything and was kept as it was found. None of the `forms` in
/// which only amplitudes are fitted may add to it or do nearly as well in its place.
pub fn stands_alone(attempt: &Attempt, outset: &Outset, forms: &[Effect]) -> bool {
    let (search, settled) = (&attempt.explanation.search, &attempt.settled);
    let (orders, others): (Vec<Term>, Vec<Term>) =
        attempt.explanation.terms.iter().cloned().partition(|term| search.is_order(term.family));
    let [own] = &others[..] else { return false };
    let kept = attempt.said.verdict == Verdict::Explained
        && settled.handed.terms.len() == 1
        && settled.judged.is_empty()
        && settled.ambiguous.is_empty();
    // What an effect that is not quite right leaves is taken for correlated noise.
    let correlated = search.noise.correlation.typical() > outset.correlation() + MORE_CORRELATED;
    kept && !correlated && !is_loop(search, own) && !has_rival(search, &orders, own, forms)
}

/// Whether a term follows the past of the angle. Many forms do so nearly alike, but their shapes would have to be searched.
fn is_loop(search: &Search, term: &Term) -> bool {
    let effect = search.effect(term.family).map(|e| &search.catalogue[e]);
    effect.is_none_or(|effect| ["direction", "history"].contains(&effect.place.variable.as_str()))
}

/// Whether a form in which only amplitudes are fitted adds to a term beside others, or does nearly as well in its place.
fn has_rival(search: &Search, others: &[Term], own: &Term, forms: &[Effect]) -> bool {
    let rows = search.rows;
    let can_show = |form: &&Effect| form.is_linear() && form.testable(rows).is_ok();
    let linear: Vec<Vec<Vec<f64>>> =
        forms.iter().filter(can_show).map(|form| form.signature(rows, &[])).collect();
    let with_own = [others, std::slice::from_ref(own)].concat();
    let by_chance = MISFIT / linear.len().max(1) as f64;
    let adds = |columns: &[Vec<f64>]| search.explained_beside(&with_own, columns).1 < by_chance;
    let explained = |columns: &[Vec<f64>]| search.explained_beside(others, columns).0;
    let of_own = explained(&own.columns);
    let shapes = search.effect(own.family).map_or(0, |e| search.free_shapes(e));
    let least = of_own - cost(rows.len(), own.columns.len(), shapes) - ALTERNATIVE_MARGIN;
    let does_as_well = |columns: &[Vec<f64>]| {
        let alone = explained(columns);
        // A form that holds the effect, beside the base, is no other one.
        let holds_own = explained(&[columns, &own.columns[..]].concat()) - alone < CONTAINED * of_own;
        !holds_own && alone - cost(rows.len(), columns.len(), 0) > least
    };
    linear.iter().any(|columns| adds(columns) || does_as_well(columns))
}
