//! An effect that came or went and is too weak to be named in its own recording is taken up there by damping, stiffness or
//! gain. Held against the other recording, it explains more than they do.

use numerics::parallel;

use crate::dynamic::candidates::Candidates;
use crate::dynamic::joint::{Joint, Side, Sought};
use crate::dynamic::model::Model;
use crate::thresholds::compare::{ALTERNATIVE, NOTHING_ELSE_DIFFERS};

use super::joined::differing;

/// A model of both with one effect more, of one recording alone, if the difference of this effect explains both better than
/// whatever differs without it; far better, where nothing does. `found` are the effects of each recording that are tried, and
/// `of` makes the model of both with one of them.
pub fn with_best_name<S: Side>(
    plain: Joint<S>,
    found: &[Candidates; 2],
    of: impl Fn(usize, &Model) -> Option<Joint<S>> + Sync,
) -> Joint<S> {
    let changed = differing(&plain);
    let sought = found.iter().map(|found| found.sought).sum::<usize>();
    let of_side = |side: usize| found[side].models.iter().map(move |model| (side, model));
    let tried: Vec<(usize, &Model)> = of_side(0).chain(of_side(1)).collect();
    let least = if changed.is_empty() { NOTHING_ELSE_DIFFERS } else { 0.0 };
    let mut with = parallel::filter_map(&tried, |(side, model)| {
        let joint = of(*side, model)?.sought_among(sought);
        let of_id = |id: &str| joint.groups.iter().position(|group| group.id == id);
        let group = of_id(model.terms.last()?.effect.id)?;
        let without: Vec<usize> = changed.iter().filter_map(|k| of_id(&plain.groups[*k].id)).collect();
        // In the same model: what the effect explains of both recordings alike is no reason that it differs.
        let gain = joint.criterion(&without) - joint.criterion(&[group]);
        (gain > least).then_some(With { gain, side: *side, group, joint })
    });
    with.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let Some(best) = with.iter().position(With::is_possible) else { return plain };
    let With { gain, side, group, mut joint } = with.remove(best);
    let id = joint.groups[group].id.clone();
    let mut rivals: Vec<String> = Vec::new();
    let is_near = |other: &&With<S>| other.gain > gain - 2.0 * ALTERNATIVE && other.is_possible();
    for other in with.iter().filter(is_near) {
        let rival = &other.joint.groups[other.group].id;
        if *rival != id && !rivals.contains(rival) {
            rivals.push(rival.clone());
        }
    }
    joint.found = Some(Sought { recording: side, id, rivals });
    joint
}

/// A model of both with one effect more, of the recording `side`.
struct With<S> {
    /// By how much Akaike's criterion falls.
    gain: f64,
    side: usize,
    group: usize,
    joint: Joint<S>,
}

impl<S: Side> With<S> {
    /// Whether the effect can have the parameters that it has there.
    fn is_possible(&self) -> bool {
        let With { group, joint, .. } = self;
        joint.is_plausible(*group, &[*group]) && joint.is_plausible(*group, &differing(joint))
    }
}
