//! Whether one named effect explains a recording so clearly that no form without a name can take its place: then forms
//! are not searched, which takes as long as everything before.

use crate::attempt::Attempt;
use crate::dictionary::Kind;
use crate::explain::Outset;
use crate::generic::observables;
use crate::search::Term;
use crate::thresholds::alone::MORE_CORRELATED;
use crate::thresholds::verdict::ALTERNATIVE_MARGIN;
use crate::verdict::Verdict;

/// Whether an attempt without forms is one effect that explains everything and was kept as it was found, while no curve over
/// another column comes near it.
pub fn stands_alone(attempt: &Attempt, outset: &Outset) -> bool {
    let (search, settled) = (&attempt.explanation.search, &attempt.settled);
    let is_order = |term: &&Term| matches!(search.dictionary.families[term.family].kind, Kind::Order);
    let (orders, others): (Vec<&Term>, Vec<&Term>) = attempt.explanation.terms.iter().partition(is_order);
    let [own] = others[..] else { return false };
    let kept = attempt.said.verdict == Verdict::Explained
        && settled.handed.terms.len() == 1
        && settled.judged.is_empty()
        && settled.ambiguous.is_empty();
    // What an effect that is not quite right leaves is taken for correlated noise.
    let correlated = search.noise.correlation.typical() > outset.correlation() + MORE_CORRELATED;
    let Some(effect) = search.effect(own.family).map(|e| &search.catalogue[e]) else { return false };
    // Many forms follow the angle's past as a loop does, and no curve shows them.
    let a_loop = ["direction", "history"].contains(&effect.place.variable.as_str());
    if !kept || correlated || a_loop {
        return false;
    }
    let orders: Vec<Term> = orders.into_iter().cloned().collect();
    let columns: Vec<String> = observables(search.rows).into_iter().map(|observed| observed.name).collect();
    let of_own = |name: &String| *name == effect.place.variable || effect.place.times.as_ref() == Some(name);
    let of_another_column = |family: usize| match &search.dictionary.families[family].kind {
        Kind::Generic(place) => {
            let mut names = [Some(&place.variable), place.times.as_ref()].into_iter().flatten();
            names.any(|name| columns.contains(name) && !of_own(name))
        }
        _ => false,
    };
    let own = search.explained(&attempt.explanation.terms) - search.explained(&orders);
    let near = search.contenders(&orders, of_another_column);
    near.iter().all(|found| found.explained < own - ALTERNATIVE_MARGIN)
}
