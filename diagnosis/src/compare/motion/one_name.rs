//! One effect may have another name in each recording: a delay here, a lag of the drive there. A model with both follows
//! either badly where they are the same; with the effects of one recording alone both may be explained as well.

use crate::dynamic::joint::{Joint, Side};
use crate::dynamic::model::Model;

use super::joined::differing;

/// The models of two recordings with the model of both that `of` makes of them; in the place of either that of the other one,
/// if each has an effect that the other has not and Akaike's criterion asks for no more.
pub fn of_one_name<'m, S: Side>(
    models: [&'m Model; 2],
    of: impl Fn([&'m Model; 2]) -> Option<Joint<S>>,
) -> Option<([&'m Model; 2], Joint<S>)> {
    let [then, now] = models;
    let has = |model: &Model, id: &str| model.terms.iter().any(|term| term.effect.id == id);
    let has_more = |a: &Model, b: &Model| a.terms.iter().any(|term| !has(b, term.effect.id));
    let tried = match has_more(then, now) && has_more(now, then) {
        true => vec![models, [then; 2], [now; 2]],
        false => vec![models],
    };
    let with_criterion = |models| {
        let joint = of(models)?;
        let criterion = joint.criterion(&differing(&joint)) + 2.0 * joint.in_common() as f64;
        Some((criterion, (models, joint)))
    };
    let all = tried.into_iter().filter_map(with_criterion);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, best)| best)
}
