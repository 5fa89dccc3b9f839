//! One effect may have a different name in each recording: a delay in one, a lag of the drive in the other. A model with both
//! would say that one went and the other came. The effects of one recording may explain both as well. And an effect that only
//! one recording has may be another, which that recording cannot distinguish from it, but both together can.

use crate::dynamic::joint::{Joint, Side, Sought};
use crate::dynamic::model::Model;
use crate::dynamic::search::Augmented;
use crate::thresholds::compare::ALTERNATIVE;

use super::joined::differing;
use super::with;

/// The pair of models from which `of` makes the model of both recordings with the least Akaike criterion, and that model: each
/// recording's own; that of one recording for both, tried where each has an effect that the other lacks; or one of the `rivals`
/// of a recording's own model, which has to be clearly better.
pub fn of_one_name<'m, S: Side>(
    models: [&'m Model; 2],
    rivals: [&'m [Model]; 2],
    of: impl Fn([&'m Model; 2]) -> Option<Joint<S>>,
) -> Option<([&'m Model; 2], Joint<S>)> {
    let [then, now] = models;
    let has_more = |a: &Model, b: &Model| a.terms.iter().any(|term| !b.has(term.effect.id));
    let mut tried = vec![(models, None)];
    if has_more(then, now) && has_more(now, then) {
        tried.extend([([then; 2], None), ([now; 2], None)]);
    }
    for (side, rivals) in rivals.into_iter().enumerate() {
        let last = |rival: &'m Model| rival.terms.last().map(|term| (side, term.effect.id));
        tried.extend(rivals.iter().map(|rival| (with(models, side, rival), last(rival))));
    }
    let mut all: Vec<Tried<S>> = tried
        .into_iter()
        .filter_map(|(models, rival)| {
            let joint = of(models)?;
            let criterion = joint.criterion(&differing(&joint)) + 2.0 * joint.in_common() as f64;
            Some(Tried { models, rival, criterion, joint })
        })
        .collect();
    let margin = |tried: &Tried<S>| if tried.rival.is_some() { 2.0 * ALTERNATIVE } else { 0.0 };
    let order = |a: &usize, b: &usize| {
        let of = |k: &usize| all[*k].criterion + margin(&all[*k]);
        of(a).total_cmp(&of(b))
    };
    let best = (0..all.len()).min_by(order)?;
    let Tried { models, rival, criterion, mut joint } = all.swap_remove(best);
    joint.found = rival.map(|(recording, id)| {
        let near = all.iter().filter(|other| other.criterion < criterion + 2.0 * ALTERNATIVE);
        let others = near.filter_map(|other| other.rival).filter(|other| other.0 == recording);
        Sought { recording, id: id.into(), rivals: others.map(|(_, other)| other.into()).collect() }
    });
    Some((models, joint))
}

/// A pair of models with the model of both.
struct Tried<'m, S> {
    models: [&'m Model; 2],
    /// The recording whose own model has another name for an effect, and that name.
    rival: Option<(usize, &'static str)>,
    criterion: f64,
    joint: Joint<S>,
}
