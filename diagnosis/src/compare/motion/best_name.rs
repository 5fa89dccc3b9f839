//! An effect that came or went and is too weak to be named in its own recording is taken up there by damping, stiffness or
//! gain. Held against the other recording, it explains more than they do.

use numerics::parallel;

use crate::dynamic::DynamicRecording;
use crate::dynamic::candidates::candidates;
use crate::dynamic::joint::Joint;
use crate::dynamic::model::Model;
use crate::thresholds::compare::{CANDIDATES_IN_MOTION, NOTHING_ELSE_DIFFERS};

use super::joined::differing;

/// The model of both with one effect more, of one recording alone, if the difference of this effect explains both better
/// than whatever differs by `joint`; far better, where nothing does.
pub fn with_best_name<'a>(
    joint: Joint<'a>,
    recordings: [&'a DynamicRecording; 2],
    models: [&Model; 2],
    wider: [f64; 2],
    skip: &[String],
) -> Joint<'a> {
    let changed = differing(&joint);
    let found = parallel::indices(0..2, |side| {
        candidates(recordings[side], models[side], skip, CANDIDATES_IN_MOTION)
    });
    let sought = found.iter().map(|found| found.sought).sum::<usize>();
    let of_side = |side: usize| found[side].models.iter().map(move |model| (side, model));
    let tried: Vec<(usize, &Model)> = of_side(0).chain(of_side(1)).collect();
    let with = parallel::filter_map(&tried, |(side, model)| {
        let mut models = models;
        models[*side] = model;
        let id = model.terms.last()?.effect.id;
        let joint = Joint::new(recordings, models, wider)?.sought_among(sought);
        let group = joint.groups.iter().position(|group| group.id == id)?;
        Some((joint.criterion(&[group]), joint))
    });
    let best = with.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let least = if changed.is_empty() { NOTHING_ELSE_DIFFERS } else { 0.0 };
    let before = joint.criterion(&changed);
    best.filter(|(after, _)| *after < before - least).map_or(joint, |(_, joint)| joint)
}
