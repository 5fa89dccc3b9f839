//! What a recording does not tell apart although it matters in others: two effects that fit alike where the angle and the
//! columns moved together, and say different things where they come together differently.

use crate::effects::Effect;
use crate::explain::Explanation;
use crate::generic::beside_the_angle;
use crate::model::predictive;
use crate::numerics::{centred, dot};
use crate::rows::Rows;
use crate::search::{Found, Term};
use crate::thresholds::elsewhere::{DISAGREES, LATER};
use crate::thresholds::search::SHAPE_PRICE;
use crate::thresholds::verdict::ALTERNATIVE_MARGIN;

/// An effect that does nearly as well in the term's place beside the others, would show in other recordings of the device as
/// well, and disagrees with it where the columns come at another time. Only what needs no shape to be searched counts: with
/// one nearly everything is imitated by something far-fetched.
pub fn contradicted<'c>(
    explanation: &Explanation,
    catalogue: &'c [Effect],
    order: usize,
    others: &[Term],
    term: &Term,
) -> Option<&'c Effect> {
    let search = &explanation.search;
    let rows = search.rows;
    let own = search.effect(term.family)?;
    let with = |added: &Term| -> Vec<Term> { others.iter().chain([added]).cloned().collect() };
    let explained = |added: &Term| search.explained(&with(added)) - search.explained(others);
    let free = |term: &Term| search.effect(term.family).map_or(0, |e| search.free_shapes(e)) as f64;
    // A column more costs what the Bayesian information criterion says.
    let cost = |term: &Term| (rows.len() as f64).ln() * term.columns.len() as f64 + SHAPE_PRICE * free(term);
    let least = explained(term) - cost(term) - ALTERNATIVE_MARGIN;
    let plain = |e: usize| !catalogue[e].of_one_time && search.free_shapes(e) == 0;
    let of_device = |f: usize| search.effect(f).is_some_and(|e| e != own && plain(e));
    let as_good = |found: &&Found| found.explained - cost(&found.term) > least;
    let elsewhere = LATER.map(|part| columns_later(rows, part));
    // What base and terms say where the last term sees the columns of another time, and that term's part of it.
    let foretold = |added: &Term, later: &Rows| {
        let model = predictive(explanation, &with(added), order);
        let (last, e) = (model.terms.last()?, search.effect(added.family)?);
        let mut part = vec![0.0; rows.len()];
        for (amplitude, column) in last.amplitudes.iter().zip(catalogue[e].signature(later, &added.shape)) {
            part.iter_mut().zip(column).for_each(|(p, c)| *p += amplitude * c);
        }
        let whole = model.value().into_iter().zip(&last.contribution).zip(&part).map(|((v, c), p)| v - c + p);
        Some((centred(&whole.collect::<Vec<f64>>()), centred(&part)))
    };
    let disagree = |rival: &Term, later: &Rows| {
        let ((whole, part), (other, _)) = (foretold(term, later)?, foretold(rival, later)?);
        let apart: Vec<f64> = whole.iter().zip(&other).map(|(a, b)| a - b).collect();
        Some(dot(&apart, &apart) > DISAGREES * DISAGREES * dot(&part, &part))
    };
    let disagrees = |found: &&Found| elsewhere.iter().any(|later| disagree(&found.term, later) == Some(true));
    let found = search.contenders(others, of_device);
    let rival = found.iter().filter(as_good).find(disagrees)?;
    Some(&catalogue[search.effect(rival.term.family)?])
}

/// The rows with what was recorded beside the angle that part of the recording later. What goes with the angle does so in any
/// recording; that a temperature does is chance.
fn columns_later(rows: &Rows, part: f64) -> Rows {
    let mut later = rows.clone();
    let (by, x) = ((part * rows.len() as f64) as usize, rows.scaled_reading());
    let of_the_device = [&mut later.common_mode_um, &mut later.cross_arcsec, &mut later.coil_a];
    let further = later.extra.iter_mut().map(|column| &mut column.values);
    let by_itself = |column: &&mut Vec<f64>| beside_the_angle(column, &x).is_none();
    let of_the_device = of_the_device.into_iter().flatten().chain(further).filter(by_itself);
    later.temperature_c.iter_mut().chain(of_the_device).for_each(|column| column.rotate_left(by));
    later
}
