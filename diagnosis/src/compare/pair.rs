//! The model of two diagnosed recordings, and the parts of it that differ.

use std::collections::BTreeSet;
use std::ops::Range;

use numerics::{centred, least_squares, rms};

use crate::base::base_columns;
use crate::diagnosis::Outcome;
use crate::effects::Effect;
use crate::explain::covariates;
use crate::generic::slow_structure;
use crate::noise::{Noise, estimate_with};
use crate::rows::Rows;
use crate::thresholds::compare::{FALSE_ALARMS, ZEROS};
use crate::verdict::{angle_name, values_of};

use super::alternatives::add_alternatives;
use super::best_name::best_names;
use super::changes::{Differences, noise_change};
use super::choose::{Chosen, tests_of};
use super::design::{Design, Fitted, What, White};
use super::events::{self, Event};
use super::joined::{Joined, ranges};
use super::names::one_name_for_both;
use super::proof::prove;
use super::shared::{Shared, shared};
use super::{Compared, Comparison, Kind, Points, Side};

/// Two diagnosed recordings.
pub struct Pair<'a> {
    outcomes: &'a [Outcome; 2],
    /// What forms add in each recording beyond the effects that they nearly are.
    beyond: [Vec<Event>; 2],
    both: Joined,
    notes: Vec<String>,
}

impl<'a> Pair<'a> {
    /// Of the earlier and the later recording, with what each has for itself beyond what was found.
    pub fn new(outcomes: &'a [Outcome; 2], beyond: [Vec<Event>; 2]) -> Pair<'a> {
        let mut both = Joined::new(&outcomes[0].rows, &outcomes[1].rows);
        let order = order(outcomes);
        // Where the base is of the true position itself, it is only right once the zeros are the same.
        let mut moved = 0.0;
        for _ in 0..ZEROS {
            let to = moved_zero(&both, order);
            both.move_zero(to - moved);
            moved = to;
        }
        Pair { outcomes, beyond, both, notes: Vec::new() }
    }

    fn rows(&self, recording: usize) -> &'a Rows {
        &self.outcomes[recording].rows
    }

    /// What changed.
    pub fn compared(mut self, catalogue: &[Effect]) -> Compared {
        let shared = shared(self.outcomes, &self.both, &mut self.notes);
        self.note_ranges();
        let unmeasured = self.undetermined(&shared);
        let events = [0, 1].map(|recording| {
            [events::of(&self.outcomes[recording], &shared), self.beyond[recording].clone()].concat()
        });
        let mut design =
            Design::new(&self.both, order(self.outcomes), events::own(&self.both, &events), shared);
        let noise = [self.noise(&design, &events[0], 0), self.noise(&design, &events[1], 1)];
        let needed = [0, 1].map(|recording| {
            events::needed(&events[recording], &noise[recording], &self.model(&design, recording))
        });
        if needed != events {
            design = Design::new(
                &self.both,
                order(self.outcomes),
                events::own(&self.both, &needed),
                design.shared,
            );
        }
        let white = White::new(&noise, &unmeasured);
        let freedom = noise[0].freedom + noise[1].freedom;
        let mut design = one_name_for_both(design, &white, freedom);
        // Each effect about its own strength in each recording; then its shape, the same in both.
        let amplitudes = design.amplitudes();
        design.settle(&white, &amplitudes);
        let mut notes = Vec::new();
        let (mut design, mut chosen) = best_names(design, &white, freedom, catalogue, &mut notes);
        let amplitudes = design.amplitudes();
        let tests = tests_of(&design);
        keep_shown(&design, &noise, &unmeasured, [self.rows(0), self.rows(1)], &mut chosen, &mut notes);
        let same = design.fit(&white, &[]);
        let shapes: Vec<What> =
            chosen.iter().map(|c| c.what).filter(|what| matches!(what, What::Shape(..))).collect();
        if !shapes.is_empty() {
            design.refine(&white, &[amplitudes, shapes].concat());
        }
        let fitted = design.fit(&white, &parts_of(&design, &chosen));
        let differences = Differences { design: &design, fitted: &fitted, now: self.rows(1), freedom, tests };
        give_base_to_effects(&differences, &mut chosen, &mut notes);
        let mut changes = differences.changes(chosen);
        changes.extend(noise_change(&noise, tests));
        let effects = self.outcomes.each_ref().map(|outcome| &outcome.diagnosis.effects[..]);
        add_alternatives(&mut changes, effects);
        let left = |fit: &Fitted| -> Vec<f64> {
            let now = fit.value().split_off(self.both.split);
            centred(
                &now.iter().zip(&noise[1].clean).map(|(value, clean)| clean - value).collect::<Vec<f64>>(),
            )
        };
        let (left_same, left_changed) = (left(&same), left(&fitted));
        let variable = changes.iter().find_map(|change| change.place.as_ref()).map(|p| p.variable.clone());
        let variable = variable.unwrap_or_else(|| angle_name(self.rows(1)));
        let over = values_of(self.rows(1), &variable);
        let rows = over.iter().zip(left_same.iter().zip(&left_changed));
        let rows = rows.map(|(value, (same, changed))| [*value, *same, same - changed]).collect();
        let would_have_seen = differences.would_have_seen(&white, noise[1].level);
        let comparison = Comparison {
            schema: 1,
            verdict: if changes.is_empty() { "unchanged" } else { "changed" },
            unit: self.both.rows.unit.clone(),
            then: Side::of(&self.outcomes[0].diagnosis),
            now: Side::of(&self.outcomes[1].diagnosis),
            left: [rms(&left_same), rms(&left_changed)],
            changes,
            false_alarms: FALSE_ALARMS,
            would_have_seen,
            notes: [self.notes, notes].concat(),
        };
        Compared { comparison, points: Points { variable, rows } }
    }

    /// The rows that do not determine an effect that was found.
    fn undetermined(&self, shared: &[Shared]) -> Vec<usize> {
        let effects = || shared.iter().filter_map(|shared| shared.effect.as_ref());
        let of = |recording: usize| {
            let noise = self.outcomes[recording].diagnosis.noise_floor.value;
            effects().flat_map(move |e| e.undetermined_rows(self.rows(recording), noise))
        };
        of(0).chain(of(1).map(|row| row + self.both.split)).collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// The common model of a recording, over its rows.
    fn model(&self, design: &Design, recording: usize) -> Vec<Vec<f64>> {
        let here = self.recording(recording);
        let constant = base_columns(&self.both.rows, 0).swap_remove(0);
        let parts = design.parts.iter().flat_map(|part| &part.columns);
        let of_rows = std::iter::once(&constant).chain(parts).map(|column| column[here.clone()].to_vec());
        std::iter::once(vec![1.0; here.len()]).chain(of_rows).collect()
    }

    /// The rows of a recording among those of both.
    fn recording(&self, recording: usize) -> Range<usize> {
        if recording == 0 { 0..self.both.split } else { self.both.split..self.both.rows.len() }
    }

    /// The noise of a recording beside its part of the model.
    fn noise(&self, design: &Design, events: &[Event], recording: usize) -> Noise {
        let rows = self.rows(recording);
        let model = [self.model(design, recording), events.concat()].concat();
        estimate_with(
            &rows.error,
            &rows.t_s,
            &model,
            &model,
            &covariates(rows),
            &slow_structure(rows),
            rows.sort(),
        )
    }

    /// Says where the recordings were taken under other conditions, which may be what changed.
    fn note_ranges(&mut self) {
        for (name, [then, now]) in ranges(self.rows(0), self.rows(1)) {
            if then[1] < now[0] || now[1] < then[0] {
                self.notes.push(format!(
                    "{name} was {:.4} to {:.4} then and is {:.4} to {:.4} now: what changed may be what it does",
                    then[0], then[1], now[0], now[1]
                ));
            }
        }
    }
}

/// The higher of the orders of the base.
fn order(outcomes: &[Outcome; 2]) -> usize {
    outcomes.iter().map(|outcome| outcome.after.order).max().unwrap_or(1)
}

/// How much higher the error's constant is in the later recording: so much lower is the zero of its reference.
fn moved_zero(both: &Joined, order: usize) -> f64 {
    let n = both.rows.len();
    let mut columns = vec![(0..n).map(|i| f64::from(u8::from(i >= both.split))).collect(), vec![1.0; n]];
    columns.extend(base_columns(&both.rows, order));
    least_squares(&columns, &both.rows.error).coefficients[0]
}

/// The numbers of the parts that differ.
fn parts_of(design: &Design, chosen: &[Chosen]) -> Vec<usize> {
    chosen.iter().filter_map(|c| design.part(c.what)).collect()
}

/// Withdraws the parts with which held-out rows are not predicted better, and says so.
fn keep_shown(
    design: &Design,
    noise: &[Noise; 2],
    unmeasured: &[usize],
    recordings: [&Rows; 2],
    chosen: &mut Vec<Chosen>,
    notes: &mut Vec<String>,
) {
    let mut k = 0;
    while k < chosen.len() {
        let changed = parts_of(design, chosen);
        let others = chosen.iter().filter(|c| !c.what.belongs_to(chosen[k].what));
        let fewer: Vec<usize> = others.filter_map(|c| design.part(c.what)).collect();
        chosen[k].proof = prove(design, noise, unmeasured, recordings, &changed, &fewer);
        if chosen[k].proof.as_ref().is_some_and(|proof| proof.gain.value <= 0.0) {
            let id = design.id(chosen.remove(k).what);
            notes.push(format!("{id}: a difference is not shown on held-out rows, and is withdrawn"));
            // The others were shown beside it.
            k = 0;
        } else {
            k += 1;
        }
    }
}

/// Where an effect came or went, what differs of the base is taken for a part of it: what an effect refers to (a
/// temperature, a position at rest) it shares with the base.
fn give_base_to_effects(differences: &Differences, chosen: &mut Vec<Chosen>, notes: &mut Vec<String>) {
    let one_sided = |c: &&Chosen| matches!(differences.kind(c.what), Kind::Came | Kind::Went);
    let Some(effect) = chosen.iter().find(one_sided).map(|c| differences.design.id(c.what)) else { return };
    let all = chosen.len();
    chosen.retain(|c| c.what.effect().is_some());
    if chosen.len() < all {
        notes.push(format!("the base differs as well: it may be a part of {effect}"));
    }
}
