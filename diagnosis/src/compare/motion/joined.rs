//! Which parameters of one model of both recordings differ: the fewest beside which no other does, each shown on rows
//! that its fit has not seen.

use numerics::rms;

use crate::dynamic::joint::{Both, Group, Joint, Of, Side, Solved};
use crate::held_out::gain;
use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::{ALTERNATIVE, FALSE_ALARMS};

use super::super::choose::visible;
use super::super::stepwise::stepwise;
use super::super::{Change, Comparison, HeldOut, Kind, Quantity, Visible};
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
    pub(super) fn joined<S: Side>(&self, joint: &Joint<S>) -> Comparison {
        let mut chosen = choose(joint);
        let mut notes = Vec::new();
        if !chosen.is_empty() {
            self.keep_shown(joint, &joint.without_each(), &mut chosen, &mut notes);
        }
        let changed = groups(&chosen);
        let (same, solved) = (joint.solve(&[]), joint.solve(&changed));
        let mut changes: Vec<Change> = chosen.into_iter().map(|c| self.change(joint, &solved, c)).collect();
        changes.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        let own = self.now.diagnosis.fit.after.train_rms;
        let left = [&same, &solved].map(|solved| joint.rms(solved).unwrap_or(own));
        let smallest = |group: usize| {
            let extended = (!changed.contains(&group)).then(|| joint.extended(&solved, group));
            let solved = extended.as_ref().unwrap_or(&solved);
            let first = || joint.parameters(solved, group).into_iter().next();
            let (name, error) = match joint.ratio(solved, group) {
                Some((_, error)) => (joint.groups[group].id.clone(), error),
                None => first().map(|first| (first.then.name, first.error))?,
            };
            let id = self.names.for_both(&joint.groups[group].id);
            let least = visible(1, joint.looked_at()) * error;
            // Of what neither recording determines nothing would have been seen.
            (least > 0.0).then_some(Visible { id, rms: None, parameter: Some((name, least)) })
        };
        let mut comparison = self.of(changes, left);
        // An effect that may differ in two ways is there once.
        let first =
            |group: &usize| joint.groups[..*group].iter().all(|other| other.id != joint.groups[*group].id);
        comparison.would_have_seen = (0..joint.groups.len()).filter(first).filter_map(smallest).collect();
        comparison.notes.extend(notes);
        comparison
    }

    fn change<S: Side>(&self, joint: &Joint<S>, solved: &Solved, chosen: Chosen) -> Change {
        let Chosen { group, p_value, alternatives, held_out } = chosen;
        let id = &joint.groups[group].id;
        let present = |recording: usize| {
            let own = self.names.within(recording, id);
            self.sides()[recording].effects.iter().any(|effect| effect.id == own)
                || joint.shows(solved, group, recording)
        };
        let kind = match (present(0), present(1)) {
            (false, true) => Kind::Came,
            (true, false) => Kind::Went,
            _ => Kind::Moved,
        };
        // An effect that may differ in two ways is there once.
        let others = alternatives.iter().map(|other| &joint.groups[*other].id).filter(|other| *other != id);
        let mut alternatives: Vec<String> = others.map(|other| self.names.for_both(other)).collect();
        alternatives.dedup();
        let rivals = joint.found.iter().filter(|found| found.id == *id).flat_map(|found| &found.rivals);
        let new: Vec<String> = rivals.filter(|rival| !alternatives.contains(rival)).cloned().collect();
        alternatives.extend(new);
        let shown = |moved: &Both| {
            let mut one = quantity(&moved.then, &moved.now, moved.error);
            // A shape that both have in common.
            one.difference = one.difference.filter(|_| moved.error > 0.0);
            if !moved.grows && kind != Kind::Moved {
                let absent = if kind == Kind::Came { &mut one.then } else { &mut one.now };
                (*absent, one.difference) = (None, None);
            }
            one
        };
        Change {
            id: self.names.for_both(id),
            title: joint.groups[group].title.clone(),
            kind,
            place: joint.place(group, p_value),
            p_value,
            rms: None,
            parameters: match joint.ratio(solved, group) {
                // Of what was not there nothing is so many times as large.
                Some(_) if kind == Kind::Came => Vec::new(),
                Some((ratio, error)) => vec![Quantity::ratio(id, ratio, interval(ratio, error))],
                None => joint.parameters(solved, group).iter().map(shown).collect(),
            },
            alternatives,
            held_out,
        }
    }

    /// Withdraws what does not predict the held-out rows better, and says so; `without` are fitted without those of one kind.
    fn keep_shown<S: Side>(
        &self,
        joint: &Joint<S>,
        without: &[(usize, Joint<S>)],
        chosen: &mut Vec<Chosen>,
        notes: &mut Vec<String>,
    ) {
        let mut k = 0;
        while k < chosen.len() {
            let all = groups(chosen);
            let fewer: Vec<usize> = all.iter().copied().filter(|g| *g != all[k]).collect();
            let scores = without.iter().flat_map(|(kind, joint)| {
                let models = [joint.solve(&fewer), joint.solve(&all)];
                joint.scores(*kind, [&models[0], &models[1]]).unwrap_or_default()
            });
            let scores: Vec<[f64; 2]> = scores.collect();
            chosen[k].held_out = (!scores.is_empty()).then(|| {
                let of = |model: usize| rms(&scores.iter().map(|score| score[model]).collect::<Vec<f64>>());
                let gains: Vec<f64> = scores.iter().map(|[same, changed]| same - changed).collect();
                HeldOut { same: of(0), changed: of(1), gain: gain(&gains) }
            });
            let explains = |shown: &HeldOut| 1.0 - (shown.changed / shown.same).powi(2);
            let too_little =
                |shown: &HeldOut| shown.gain.value <= 0.0 || explains(shown) < joint.least_part();
            if chosen[k].held_out.as_ref().is_some_and(too_little) {
                let id = self.names.for_both(&joint.groups[chosen.remove(k).group].id);
                notes.push(format!("{id}: a difference is not shown on held-out rows, and is withdrawn"));
                k = 0;
            } else {
                k += 1;
            }
        }
    }
}

fn interval(value: f64, error: f64) -> [f64; 2] {
    [value - NORMAL_95 * error, value + NORMAL_95 * error]
}

fn groups(chosen: &[Chosen]) -> Vec<usize> {
    chosen.iter().map(|c| c.group).collect()
}

/// The numbers of the groups that differ.
pub fn differing<S: Side>(joint: &Joint<S>) -> Vec<usize> {
    groups(&choose(joint))
}

/// The most surprising group. Where that is a part of an effect under the name of a simpler one (the dry part of Stribeck friction),
/// the whole effect if it does nearly as well: it is the one in the model.
fn strongest(groups: &[Group], surprises: &[f64]) -> Option<usize> {
    let best = (0..groups.len()).max_by(|a, b| surprises[*a].total_cmp(&surprises[*b]))?;
    let Of::Term(term) = groups[best].of else { return Some(best) };
    let of_term = |k: &usize| matches!(groups[*k].of, Of::Term(other) if other == term);
    let own = (0..groups.len()).find(of_term)?;
    let whole = |k: &usize| of_term(k) && groups[*k].id == groups[own].id;
    let near = |k: &usize| surprises[*k] > surprises[best] - ALTERNATIVE;
    let wholes = (0..groups.len()).filter(|k| whole(k) && near(k));
    wholes.max_by(|a, b| surprises[*a].total_cmp(&surprises[*b])).or(Some(best))
}

/// The groups that differ; where none does by itself, two that hide each other: more friction and less damping.
fn choose<S: Side>(joint: &Joint<S>) -> Vec<Chosen> {
    let steps = stepwise(
        |changed| joint.surprises(changed),
        |surprises| strongest(&joint.groups, surprises),
        |_, surprise| joint.family_wise(surprise),
    );
    let chosen = |group, p_value, alternatives| Chosen { group, p_value, alternatives, held_out: None };
    if !steps.is_empty() {
        return steps.into_iter().map(|step| chosen(step.number, step.p_value, step.alternatives)).collect();
    }
    let Some(([a, b], p_value)) = joint.pair() else { return Vec::new() };
    let both = [a, b].map(|group| chosen(group, p_value, Vec::new()));
    both.into_iter().filter(|_| p_value <= FALSE_ALARMS).collect()
}

#[cfg(test)]
mod tests {
    use super::strongest;
    use crate::dynamic::joint::{Group, Of};

    #[test]
    fn what_both_recordings_have_moves_as_a_whole_unless_its_part_does_better() {
        let group = |id: &str, of| Group { id: id.into(), title: id.into(), directions: Vec::new(), of };
        let groups = [
            group("damping", Of::Plant(0)),
            group("stribeck_friction", Of::Term(0)),
            group("stribeck_friction", Of::Term(0)),
            group("coulomb_friction", Of::Term(0)),
        ];
        assert_eq!(strongest(&groups, &[5.0, 40.0, 48.0, 50.0]), Some(2));
        assert_eq!(strongest(&groups, &[5.0, 30.0, 45.0, 50.0]), Some(3));
        assert_eq!(strongest(&groups, &[60.0, 30.0, 45.0, 50.0]), Some(0));
        assert_eq!(strongest(&[], &[]), None);
    }
}
