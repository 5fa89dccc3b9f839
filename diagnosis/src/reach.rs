//! What of an effect is handed on to other recordings of the device, where something that happened at one time of this
//! one (a step, a drift, two of them) does nearly as well in its place.

use std::collections::BTreeSet;

use numerics::{Basis, centred, dot};

use crate::base::base_columns;
use crate::effects::Effect;
use crate::explain::Explanation;
use crate::judge::Settled;
use crate::model::{FittedTerm, Model};
use crate::search::{Found, Term};
use crate::thresholds::averaging::ODDS;
use crate::thresholds::reach::{HALF, LITTLE};
use crate::thresholds::search::SHAPE_PRICE;
use crate::thresholds::verdict::MOST_LOG_ODDS;
use crate::verdict::{Rival, without};

/// Puts into every term the part of it that is handed on. With the probability p that it is not what happened at one
/// time, all effects being equally likely before, a part f of it leaves least on another recording in the mean (a model
/// average): of what the base would not have taken up without it (1 − f)² p + f² (1 − p), of the rest (1 − f)².
/// Says so in sentences.
pub fn reach(
    explanation: &Explanation,
    catalogue: &[Effect],
    settled: &mut Settled,
    rivals: &[Vec<Rival>],
) -> Vec<String> {
    let rows = explanation.search.rows;
    let mut base = Basis::new(rows.len());
    for column in base_columns(rows, settled.handed.order) {
        base.add(&column);
    }
    let mut said = Vec::new();
    for (term, rivals) in settled.joint.terms.iter().zip(rivals) {
        let Some(e) = term.effect.filter(|e| !catalogue[*e].of_one_time) else { continue };
        let same = |t: &&mut FittedTerm| t.term.family == term.term.family && t.term.shape == term.term.shape;
        let Some(handed) = settled.handed.terms.iter_mut().find(same) else { continue };
        let alone = rivals.iter().map(|rival| (rival.odds, vec![rival.effect]));
        let of_one_time: Vec<(f64, Vec<usize>)> = alone
            .filter(|(_, effects)| effects.iter().all(|e| catalogue[*e].of_one_time))
            .chain(pair(explanation, catalogue, &settled.joint, &term.term))
            .collect();
        let odds: f64 = of_one_time.iter().map(|(odds, _)| odds).sum();
        let about = centred(&handed.contribution);
        let mut own = about.clone();
        base.project_off(&mut own);
        let own = dot(&own, &own) / dot(&about, &about).max(1e-300);
        let rest = own * odds / (1.0 + odds);
        if rest < LITTLE {
            continue;
        }
        handed.reach *= 1.0 - rest;
        let others: BTreeSet<&str> =
            of_one_time.iter().flat_map(|(_, effects)| effects).map(|e| catalogue[*e].id.as_str()).collect();
        said.push(format!(
            "{}: whether it holds on other recordings ({} may be what happened in this one); {:.0} % of it is handed on \
             to them",
            catalogue[e].id,
            Vec::from_iter(others).join(" or "),
            100.0 * handed.reach
        ));
    }
    said
}

/// The likeliest two effects of one time in a term's place, with their odds beside it: a column more costs what the
/// Bayesian information criterion says, an effect more its odds.
fn pair(
    explanation: &Explanation,
    catalogue: &[Effect],
    model: &Model,
    term: &Term,
) -> Option<(f64, Vec<usize>)> {
    let search = &explanation.search;
    let others = without(explanation, model, term);
    let with = |added: &Term| -> Vec<Term> { others.iter().chain([added]).cloned().collect() };
    let best = search.explained(&with(term)) - search.explained(&others);
    let of_one_time = |f: usize| {
        search
            .effect(f)
            .is_some_and(|e| catalogue[e].of_one_time && catalogue[e].testable(search.rows).is_ok())
    };
    let free = |term: &Term| search.effect(term.family).map_or(0, |e| search.free_shapes(e)) as f64;
    let beside = |first: &Found| {
        let second = search
            .contenders(&with(&first.term), |f| of_one_time(f) && f != first.term.family)
            .into_iter()
            .max_by(|a, b| a.explained.total_cmp(&b.explained))?;
        let columns = first.term.columns.len() + second.term.columns.len();
        let more = columns as f64 - term.columns.len() as f64;
        let shapes = free(&first.term) + free(&second.term) - free(term);
        let gained = first.explained + second.explained - best - SHAPE_PRICE * shapes;
        let log_odds = 0.5 * (gained - more * (search.rows.len() as f64).ln());
        let odds = ODDS * log_odds.min(MOST_LOG_ODDS).exp();
        Some((odds, vec![search.effect(first.term.family)?, search.effect(second.term.family)?]))
    };
    search
        .contenders(&others, of_one_time)
        .iter()
        .filter(|first| first.explained > HALF * best)
        .filter_map(beside)
        .max_by(|a, b| a.0.total_cmp(&b.0))
}
