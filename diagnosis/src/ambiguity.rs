//! What a recording does not tell apart although it matters in others: two effects that fit alike where the angle and the
//! columns moved together or kept to one range, and say different things elsewhere.

use numerics::{add_scaled, centred, dot, least_squares, range, rms};

use crate::effects::Effect;
use crate::explain::Explanation;
use crate::generic::beside_the_angle;
use crate::model::{Model, predictive};
use crate::rows::Rows;
use crate::search::{Found, Term};
use crate::thresholds::ambiguity::{CONTAINED, DISAGREES, SHIFTS};
use crate::thresholds::search::SHAPE_PRICE;
use crate::thresholds::verdict::{ALTERNATIVE_MARGIN, MOST_LOG_ODDS};
use crate::verdict::without;

/// A term in whose place another effect does nearly as well here and predicts something else for other recordings.
pub struct Conflict<'e, 'a> {
    /// The term.
    pub term: Term,
    /// The other effect's, as `searched` knows it.
    pub rival: Term,
    /// The other effect, by its number in the catalogue.
    pub effect: usize,
    /// How likely it is beside the term: by the Bayesian information criterion, both being equally likely before.
    pub odds: f64,
    /// The search that knows it.
    pub searched: &'e Explanation<'a>,
}

/// The conflicts of a model's terms with effects of `searched`, which may know more effects than `explanation`, in which the
/// terms were found.
pub fn conflicts<'e, 'a>(
    explanation: &Explanation,
    catalogue: &[Effect],
    joint: &Model,
    searched: &'e Explanation<'a>,
) -> Vec<Conflict<'e, 'a>> {
    let search = &searched.search;
    let rival = |term: &Term| {
        let others = without(explanation, joint, term);
        let known = search.translated(&explanation.search, &others);
        let own = search.translated(&explanation.search, std::slice::from_ref(term));
        let own = own.first().filter(|_| known.len() == others.len())?;
        search.effect(own.family).filter(|e| !catalogue[*e].of_one_time)?;
        let (rival, odds) = conflicting_rival(searched, catalogue, joint.order, &known, own)?;
        Some(Conflict { term: term.clone(), effect: search.effect(rival.family)?, rival, odds, searched })
    };
    let named = joint.terms.iter().filter(|term| term.effect.is_some());
    named.filter_map(|term| rival(&term.term)).collect()
}

/// An effect that does nearly as well in the term's place beside the others, would show in other recordings of the device as
/// well, and disagrees with it there; with its odds. Only what needs no shape to be searched counts: with one nearly everything
/// is imitated by something far-fetched.
fn conflicting_rival(
    explanation: &Explanation,
    catalogue: &[Effect],
    order: usize,
    others: &[Term],
    term: &Term,
) -> Option<(Term, f64)> {
    let search = &explanation.search;
    let rows = search.rows;
    let own = search.effect(term.family)?;
    let with = |added: &Term| -> Vec<Term> { others.iter().chain([added]).cloned().collect() };
    let explained = |added: &Term| search.explained(&with(added)) - search.explained(others);
    let free = |term: &Term| search.effect(term.family).map_or(0, |e| search.free_shapes(e));
    let cost = |term: &Term| cost(rows.len(), term.columns.len(), free(term));
    let worth = explained(term) - cost(term);
    let plain = |e: usize| !catalogue[e].of_one_time && search.free_shapes(e) == 0;
    let of_device = |f: usize| search.effect(f).is_some_and(|e| e != own && plain(e));
    let better_by = |found: &Found| found.explained - cost(&found.term) - worth;
    let as_good = |found: &&Found| better_by(found) > -ALTERNATIVE_MARGIN;
    // A richer form of the term is no other effect: what it adds was not needed here.
    let holds = |found: &&Found| term.columns.iter().all(|column| contained(column, &found.term.columns));
    let elsewhere = other_recordings(rows);
    // For each of them what base and terms say where the last term sees its columns, and that term's part of it.
    let predicted = |added: &Term| -> Option<Vec<[Vec<f64>; 2]>> {
        let model = predictive(explanation, &with(added), order);
        let (last, e) = (model.terms.last()?, search.effect(added.family)?);
        let others: Vec<f64> = model.value().iter().zip(&last.contribution).map(|(v, c)| v - c).collect();
        let under = |rows: &Rows| {
            let mut part = vec![0.0; others.len()];
            for (amplitude, column) in last.amplitudes.iter().zip(catalogue[e].signature(rows, &added.shape))
            {
                add_scaled(&mut part, *amplitude, &column);
            }
            let whole: Vec<f64> = others.iter().zip(&part).map(|(o, p)| o + p).collect();
            [centred(&whole), centred(&part)]
        };
        Some(elsewhere.iter().map(under).collect())
    };
    let own = predicted(term)?;
    let disagrees = |found: &&Found| {
        let rival = predicted(&found.term).unwrap_or_default();
        own.iter().zip(&rival).any(|([whole, part], [other, _])| {
            let apart: Vec<f64> = whole.iter().zip(other).map(|(a, b)| a - b).collect();
            rms(&apart) > DISAGREES * rms(part)
        })
    };
    let found = search.contenders(others, of_device);
    let rival = found.iter().filter(as_good).filter(|found| !holds(found)).find(disagrees)?;
    Some((rival.term.clone(), (0.5 * better_by(rival)).min(MOST_LOG_ODDS).exp()))
}

/// What an effect must explain for its freedom, in −2 log likelihood: a column what the Bayesian information criterion says, a
/// searched shape its price.
pub fn cost(rows: usize, columns: usize, shapes: usize) -> f64 {
    (rows as f64).ln() * columns as f64 + SHAPE_PRICE * shapes as f64
}

/// Whether a column is a sum of others.
pub fn contained(column: &[f64], others: &[Vec<f64>]) -> bool {
    least_squares(others, column).rss < CONTAINED * dot(column, column)
}

/// What other recordings of the device may hold: the columns come at another time, or go on beyond either end of their range.
fn other_recordings(rows: &Rows) -> Vec<Rows> {
    let later = SHIFTS.map(|part| {
        let by = (part * rows.len() as f64) as usize;
        with_columns(rows, |column| column.rotate_left(by))
    });
    let beyond = [0, 1].map(|end| {
        with_columns(rows, |column| {
            let (low, high) = range(column);
            let end = [low, high][end];
            column.iter_mut().for_each(|v| *v = 2.0 * end - *v);
        })
    });
    later.into_iter().chain(beyond).collect()
}

/// The rows with what was recorded beside the angle changed. What goes with the angle does so in any recording; that a
/// temperature does is chance.
fn with_columns(rows: &Rows, change: impl Fn(&mut Vec<f64>)) -> Rows {
    let mut other = rows.clone();
    let x = rows.scaled_reading();
    let of_the_device = [&mut other.common_mode_um, &mut other.cross_arcsec, &mut other.coil_a];
    let further = other.extra.iter_mut().map(|column| &mut column.values);
    let by_itself = |column: &&mut Vec<f64>| beside_the_angle(column, &x).is_none();
    let of_the_device = of_the_device.into_iter().flatten().chain(further).filter(by_itself);
    other.temperature_c.iter_mut().chain(of_the_device).for_each(change);
    other
}
