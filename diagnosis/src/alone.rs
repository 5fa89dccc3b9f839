//! Whether one named effect explains a recording so clearly that no form without a name can take its place: then forms
//! are not searched, which takes as long as everything before.

use std::sync::Arc;

use crate::attempt::Attempt;
use crate::dictionary::Kind;
use crate::effects::Effect;
use crate::explain::Outset;
use crate::search::Term;
use crate::thresholds::alone::MORE_CORRELATED;
use crate::thresholds::ambiguity::CONTAINED;
use crate::thresholds::search::remainder::MISFIT;
use crate::thresholds::verdict::ALTERNATIVE_MARGIN;
use crate::verdict::Verdict;

/// Whether an attempt without forms is one effect that explains everything and was kept as it was found. None of the `forms` in
/// which only amplitudes are fitted may add to it or do nearly as well in its place.
pub fn stands_alone(attempt: &Attempt, outset: &Outset, forms: &[Effect]) -> bool {
    let (search, settled, terms) =
        (&attempt.explanation.search, &attempt.settled, &attempt.explanation.terms);
    let is_order = |term: &&Term| matches!(search.dictionary.families[term.family].kind, Kind::Order);
    let (orders, others): (Vec<&Term>, Vec<&Term>) = terms.iter().partition(is_order);
    let [own] = others[..] else { return false };
    let Some(effect) = search.effect(own.family).map(|e| &search.catalogue[e]) else { return false };
    let kept = attempt.said.verdict == Verdict::Explained
        && settled.handed.terms.len() == 1
        && settled.judged.is_empty()
        && settled.ambiguous.is_empty();
    // Many forms follow the angle's past as a loop does, nearly all of them with a shape.
    let a_loop = ["direction", "history"].contains(&effect.place.variable.as_str());
    // What an effect that is not quite right leaves is taken for correlated noise.
    let correlated = search.noise.correlation.typical() > outset.correlation() + MORE_CORRELATED;
    if !kept || a_loop || correlated {
        return false;
    }
    let rows = search.rows;
    let can_show = |form: &&Effect| form.is_linear() && form.testable(rows).is_ok();
    let linear: Vec<Vec<Vec<f64>>> =
        forms.iter().filter(can_show).map(|form| form.signature(rows, &[])).collect();
    let by_chance = MISFIT / linear.len().max(1) as f64;
    let adds = |columns: &[Vec<f64>]| search.share_beside(terms, columns).1 < by_chance;
    let orders: Vec<Term> = orders.into_iter().cloned().collect();
    let of_own = search.explained(terms) - search.explained(&orders);
    let does_as_well = |columns: &[Vec<f64>]| {
        let mut with = orders.clone();
        with.push(Term::new(own.family, Vec::new(), Arc::new(columns.to_vec())));
        let explained = search.explained(&with);
        with.push(own.clone());
        // A form that holds the effect, beside the base, is no other one.
        let holds_own = search.explained(&with) - explained < CONTAINED * of_own;
        !holds_own && explained - search.explained(&orders) > of_own - ALTERNATIVE_MARGIN
    };
    !linear.iter().any(|columns| adds(columns) || does_as_well(columns))
}
