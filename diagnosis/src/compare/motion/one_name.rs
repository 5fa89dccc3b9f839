//! One effect may have a different name in each recording: a delay in one, a lag of the drive in the other. A model with both
//! would say that one went and the other came. The effects of one recording may explain both as well.

use crate::dynamic::joint::{Joint, Side};
use crate::dynamic::model::Model;

use super::joined::differing;

/// The pair of models from which `of` makes the model of both recordings with the least Akaike criterion, and that model: each
/// recording's own, or that of one recording for both. The latter are tried where each has an effect that the other lacks.
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
