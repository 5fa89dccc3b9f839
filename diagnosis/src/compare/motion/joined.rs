//! Which parameters of one model of both recordings differ: the fewest beside which no other does, each shown on rows
//! that its fit has not seen.

use fitter::plant::Plant;
use numerics::rms;

use crate::dynamic::joint::{Joint, Solved};
use crate::held_out::gain;
use crate::thresholds::compare::PRESENT;

use super::super::choose::visible;
use super::super::stepwise::{Step, stepwise};
use super::super::{Change, Comparison, HeldOut, Kind, Visible};
use super::{Pair, quantity};

/// A group of parameters that differs.
struct Chosen {
    group: usize,
    p_value: f64,
    alternatives: Vec<usize>,
    held_out: Option<HeldOut>,
}

impl Pair<'_> {
    /// What changed, by a model of both.
    pub(super) fn joined(&self, joint: &Joint, plant: &Plant) -> Comparison {
        let mut chosen = choose(joint);
        let mut notes = Vec::new();
        if let Some(unscored) = joint.unscored() {
            keep_shown(joint, &unscored, &mut chosen, &mut notes);
        }
        let changed = groups(&chosen);
        let (same, solved) = (joint.solve(&[]), joint.solve(&changed));
        let mut changes: Vec<Change> =
            chosen.into_iter().map(|c| self.change(joint, &solved, plant, c)).collect();
        changes.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        let own = self.now.diagnosis.fit.after.train_rms;
        let left = [&same, &solved].map(|solved| joint.rms(solved).unwrap_or(own));
        let smallest = |group: usize| {
            let with =
                if changed.contains(&group) { changed.clone() } else { [&changed[..], &[group]].concat() };
            let first = joint.parameters(&joint.solve(&with), group, plant).into_iter().next()?;
            let id = joint.groups[group].id.into();
            let parameter = Some((first.then.name, visible(1, joint.looked_at()) * first.error));
            Some(Visible { id, rms: None, parameter })
        };
        let mut comparison = self.of(changes, left);
        comparison.would_have_seen = (0..joint.groups.len()).filter_map(smallest).collect();
        comparison.notes.extend(notes);
        comparison
    }

    fn change(&self, joint: &Joint, solved: &Solved, plant: &Plant, chosen: Chosen) -> Change {
        let Chosen { group, p_value, alternatives, held_out } = chosen;
        let id = joint.groups[group].id;
        let present = |recording: usize| {
            self.sides()[recording].effects.iter().any(|effect| effect.id == id)
                || joint.absence(solved, group, recording) < PRESENT
        };
        Change {
            id: id.into(),
            title: joint.groups[group].title.into(),
            kind: match (present(0), present(1)) {
                (false, true) => Kind::Came,
                (true, false) => Kind::Went,
                _ => Kind::Moved,
            },
            place: self.place(id, p_value),
            p_value,
            rms: None,
            parameters: (joint.parameters(solved, group, plant).iter())
                .map(|moved| quantity(&moved.then, &moved.now, moved.error))
                .collect(),
            alternatives: alternatives.into_iter().map(|other| joint.groups[other].id.into()).collect(),
            held_out,
        }
    }
}

fn groups(chosen: &[Chosen]) -> Vec<usize> {
    chosen.iter().map(|c| c.group).collect()
}

/// The numbers of the groups that differ.
pub fn differing(joint: &Joint) -> Vec<usize> {
    groups(&choose(joint))
}

/// The groups that differ.
fn choose(joint: &Joint) -> Vec<Chosen> {
    let steps = stepwise(
        |changed| joint.surprises(changed),
        |surprises| (0..surprises.len()).max_by(|a, b| surprises[*a].total_cmp(&surprises[*b])),
        |_, surprise| (joint.looked_at() as f64 * (-surprise).exp()).min(1.0),
    );
    let chosen = |Step { number, p_value, alternatives }| Chosen {
        group: number,
        p_value,
        alternatives,
        held_out: None,
    };
    steps.into_iter().map(chosen).collect()
}

/// Withdraws what does not predict the rows better that score, and says so; `unscored` is fitted without them.
fn keep_shown(joint: &Joint, unscored: &Joint, chosen: &mut Vec<Chosen>, notes: &mut Vec<String>) {
    let mut k = 0;
    while k < chosen.len() {
        let all = groups(chosen);
        let fewer: Vec<usize> = all.iter().copied().filter(|g| *g != all[k]).collect();
        let models = [unscored.solve(&fewer), unscored.solve(&all)];
        let scores = unscored.scores([&models[0], &models[1]]).filter(|scores| !scores.is_empty());
        chosen[k].held_out = scores.map(|scores| {
            let of = |model: usize| rms(&scores.iter().map(|score| score[model]).collect::<Vec<f64>>());
            let gains: Vec<f64> = scores.iter().map(|[same, changed]| same - changed).collect();
            HeldOut { same: of(0), changed: of(1), gain: gain(&gains) }
        });
        if chosen[k].held_out.as_ref().is_some_and(|held_out| held_out.gain.value <= 0.0) {
            let id = joint.groups[chosen.remove(k).group].id;
            notes.push(format!("{id}: a difference is not shown on held-out rows, and is withdrawn"));
            k = 0;
        } else {
            k += 1;
        }
    }
}
