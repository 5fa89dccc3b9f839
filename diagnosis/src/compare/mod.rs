//! What changed between two recordings: one device at two times, a healthy and a suspect one.
//!
//! Both are diagnosed. What was found in either, and the base, make one linear model of both recordings, in which each part
//! may be the same or differ; offsets, noise, and what happened at one time belong to each recording by itself. The parts
//! that differ are chosen one by one at a family-wise false-alarm rate, and each must predict held-out rows of the later
//! recording better.

mod choose;
mod design;
mod joined;
pub mod motion;
mod proof;
mod quantity;

use std::collections::BTreeSet;
use std::ops::Range;

use fitter::{Mirror, Recording};
use serde::Serialize;

use crate::Verdict;
use crate::base::base_columns;
use crate::diagnosis::{Diagnosis, Options, Outcome, diagnose};
use crate::error::DiagnosisError;
use crate::explain::covariates;
use crate::generic::slow_structure;
use crate::held_out::Gain;
use crate::noise::{Noise, estimate};
use crate::numerics::{centred, least_squares, rms, widening};
use crate::rows::Rows;
use crate::thresholds::NORMAL_95;
use crate::thresholds::calibrate::HALF_SEEN;
use crate::thresholds::compare::{FALSE_ALARMS, LEAST_COMMON, PRESENT, ZEROS};
use crate::verdict::{Location, locate};

use choose::{Chosen, choose, noise_ratio, visible};
use design::{Design, Fitted, Shared, What, White, alike};
use joined::Joined;
pub use quantity::{Estimate, Quantity};

/// How something changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Kind {
    /// An effect is there that was not.
    Came,
    /// An effect that was there is not.
    Went,
    /// An effect is stronger, weaker or otherwise than it was.
    Moved,
    /// The base, which is what the reading says of the angle by itself.
    Base,
    /// The noise.
    Noise,
}

/// One change.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Change {
    /// Id of the effect; `gain`, `base`, `noise`, or `structure` without a name.
    pub id: String,
    /// Name for a reader.
    pub title: String,
    /// How it changed.
    pub kind: Kind,
    /// Where the difference lives; none of noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<Location>,
    /// Family-wise p-value over all that could have changed.
    pub p_value: f64,
    /// Root mean square of the difference over the later recording's rows, in the recording's unit; none of noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// Its parameters then and now.
    pub parameters: Vec<Quantity>,
    /// What else would explain the difference nearly as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<String>,
    /// The proof on held-out rows; none where nothing can be held out, and of noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

/// What is left of held-out rows of the later recording.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct HeldOut {
    /// Root mean square with this part the same in both recordings.
    pub same: f64,
    /// Where it differs.
    pub changed: f64,
    /// The mean improvement over the passes that were held out.
    pub gain: Gain,
}

/// The smallest change that would have been seen.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Visible {
    /// Id of what would have changed; `new effect` of one that neither recording has.
    pub id: String,
    /// Root mean square of the difference over the later recording that is found in 95 of 100 such pairs, in the recording's
    /// unit: an estimate. None in motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms: Option<f64>,
    /// The same of its one parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter: Option<(String, f64)>,
}

/// One of the recordings.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Side {
    /// File name.
    pub recording: String,
    /// Its own verdict.
    pub verdict: Verdict,
    /// Ids of what was found in it.
    pub effects: Vec<String>,
    /// Standard deviation of a reading's noise.
    pub noise: f64,
}

impl Side {
    fn of(diagnosis: &Diagnosis) -> Side {
        Side {
            recording: diagnosis.recording.clone(),
            verdict: diagnosis.verdict,
            effects: diagnosis.effects.iter().map(|effect| effect.id.clone()).collect(),
            noise: diagnosis.noise_floor.value,
        }
    }
}

/// What changed between two recordings.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// Version of the format.
    pub schema: u32,
    /// `changed` or `unchanged`.
    pub verdict: &'static str,
    /// The unit of the error.
    pub unit: String,
    /// The earlier recording.
    pub then: Side,
    /// The later one.
    pub now: Side,
    /// The changes, the strongest first.
    pub changes: Vec<Change>,
    /// Root mean square of what the common model leaves of the later recording where nothing differs, and with the changes; in
    /// motion what the earlier recording's model leaves of it, and its own.
    pub left: [f64; 2],
    /// Family-wise false alarms that are allowed.
    pub false_alarms: f64,
    /// How large a change of each kind would have been seen.
    pub would_have_seen: Vec<Visible>,
    /// What could not be compared, and what the comparison rests on, a sentence each.
    pub notes: Vec<String>,
}

/// A comparison with what its page is drawn from.
pub struct Compared {
    /// What is written.
    pub comparison: Comparison,
    /// The later recording's angle in its unit, what a common model without changes leaves of it, and what the changes add.
    pub points: Vec<[f64; 3]>,
}

/// Compares two recordings of a device, or of two of one kind.
///
/// # Errors
/// [`DiagnosisError`] where one of them cannot be diagnosed, or where they have no common range.
pub fn compare(
    then: &Recording,
    now: &Recording,
    mirror: &Mirror,
    options: &Options,
) -> Result<Compared, DiagnosisError> {
    let (a, b) = rayon::join(
        || diagnose(then, mirror, None, None, options),
        || diagnose(now, mirror, None, None, options),
    );
    let outcomes = [a?, b?];
    overlap(&outcomes, now)?;
    Pair::new(&outcomes).compare()
}

/// Refuses recordings of different stretches.
fn overlap(outcomes: &[Outcome; 2], now: &Recording) -> Result<(), DiagnosisError> {
    let [(a, b), (c, d)] = [outcomes[0].rows.stroke(), outcomes[1].rows.stroke()];
    if b.min(d) - a.max(c) >= LEAST_COMMON * (b - a).min(d - c) {
        return Ok(());
    }
    let unit = &outcomes[0].rows.unit;
    Err(DiagnosisError::NoCommonRange {
        file: now.file.clone(),
        found: format!("{c:.4} to {d:.4} {unit}"),
        expected: format!("{a:.4} to {b:.4} {unit}"),
    })
}

/// The higher of the orders of the base.
fn order(outcomes: &[Outcome; 2]) -> usize {
    outcomes.iter().map(|outcome| outcome.after.order).max().unwrap_or(1)
}

/// How much higher the error's constant is in the later recording: so much lower is the zero of its reference.
fn moved_zero(both: &Joined, order: usize) -> f64 {
    let (n, split) = (both.rows.len(), both.split);
    let mut columns = base_columns(&both.rows, order);
    columns.push((0..n).map(|i| f64::from(u8::from(i >= split))).collect());
    if both.rows.pair {
        columns.push(vec![1.0; n]);
    }
    let moved = least_squares(&columns, &both.rows.error).coefficients;
    moved[columns.len() - 1 - usize::from(both.rows.pair)]
}

/// Two diagnosed recordings.
struct Pair<'a> {
    outcomes: &'a [Outcome; 2],
    both: Joined,
    notes: Vec<String>,
}

impl<'a> Pair<'a> {
    fn new(outcomes: &'a [Outcome; 2]) -> Pair<'a> {
        let mut both = Joined::new(&outcomes[0].rows, &outcomes[1].rows);
        let order = order(outcomes);
        // Where the base is of the true position itself, it is only right once the zeros are the same.
        let mut moved = 0.0;
        for _ in 0..ZEROS {
            let to = moved_zero(&both, order);
            both.move_zero(to - moved);
            moved = to;
        }
        Pair { outcomes, both, notes: Vec::new() }
    }

    fn rows(&self, recording: usize) -> &'a Rows {
        &self.outcomes[recording].rows
    }

    fn split(&self) -> usize {
        self.rows(0).len()
    }

    /// The rows that do not determine an effect that was found.
    fn undetermined(&self, shared: &[Shared]) -> Vec<usize> {
        let effects = || shared.iter().filter_map(|shared| shared.effect.as_ref());
        let of = |recording: usize| {
            let noise = self.outcomes[recording].diagnosis.noise_floor.value;
            effects().flat_map(move |e| e.undetermined_rows(self.rows(recording), noise))
        };
        of(0).chain(of(1).map(|row| row + self.split())).collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// What was found of the device in either recording, once each.
    fn shared(&mut self) -> Vec<Shared> {
        let mut all: Vec<Shared> = Vec::new();
        for recording in [0, 1] {
            for term in &self.outcomes[recording].found {
                if term.effect.as_ref().is_some_and(|effect| effect.of_one_time) {
                    continue;
                }
                if let Some(Err(reason)) = term.effect.as_ref().map(|effect| effect.testable(&self.both.rows))
                {
                    let id = term.effect.as_ref().map_or("structure", |effect| &effect.id);
                    self.notes.push(format!("{id} is not compared: {reason} in both recordings"));
                    continue;
                }
                let new = Shared::of(term, recording);
                let id = |shared: &Shared| shared.effect.as_ref().map(|effect| effect.id.clone());
                let columns = new.columns(&self.both);
                if columns.is_empty() {
                    continue;
                }
                let same = |known: &&mut Shared| match (&known.effect, &new.effect) {
                    (Some(a), Some(b)) if a.id == b.id && !a.repeatable => true,
                    _ => {
                        known.place == new.place
                            && id(known) == id(&new)
                            && alike(&columns, &known.columns(&self.both))
                    }
                };
                match all.iter_mut().find(same) {
                    Some(known) if recording == 1 => {
                        // Where it is stronger its shape is known better.
                        let stronger = term.explained > self.strength(known);
                        known.meets(term, stronger, &self.both);
                    }
                    Some(_) => {}
                    None => all.push(new),
                }
            }
        }
        all
    }

    /// What the earlier recording has of an effect, in units of its noise.
    fn strength(&self, shared: &Shared) -> f64 {
        let id = |effect: &crate::effects::Effect| Some(&effect.id) == shared.effect.as_ref().map(|e| &e.id);
        let own = self.outcomes[0].found.iter().filter(|term| term.effect.as_ref().is_some_and(id));
        own.map(|term| term.explained).fold(0.0, f64::max)
    }

    /// What a recording has for itself: an offset, and what happened at one time.
    fn own(&self, recording: usize) -> Vec<Vec<f64>> {
        let rows = self.rows(recording);
        let once = self.outcomes[recording].found.iter().filter_map(|term| {
            let effect = term.effect.as_ref().filter(|effect| effect.of_one_time)?;
            Some(effect.signature(rows, &term.shape))
        });
        std::iter::once(vec![1.0; rows.len()]).chain(once.flatten()).collect()
    }

    /// The noise of a recording beside its part of the model.
    fn noise(&self, design: &Design, recording: usize) -> Noise {
        let rows = self.rows(recording);
        let here: Range<usize> =
            if recording == 0 { 0..self.split() } else { self.split()..self.both.rows.len() };
        let mut model = self.own(recording);
        let parts = design.parts.iter().flat_map(|part| &part.columns);
        model.extend(parts.map(|column| column[here.clone()].to_vec()));
        model.push(base_columns(&self.both.rows, 0)[0][here].to_vec());
        estimate(&rows.error, &rows.t_s, &model, &model, &covariates(rows), &slow_structure(rows))
    }

    fn compare(mut self) -> Result<Compared, DiagnosisError> {
        let shared = self.shared();
        self.note_ranges();
        let own = [self.own(0), self.own(1)];
        let both = self.both.clone();
        let unmeasured = self.undetermined(&shared);
        let mut design = Design::new(&both, order(self.outcomes), own, shared);
        let noise = [self.noise(&design, 0), self.noise(&design, 1)];
        let white = White::new(&noise, &unmeasured);
        // Each effect about its own strength in each recording; then its shape, the same in both.
        let amplitudes = |design: &Design| -> Vec<What> {
            let all = design.parts.iter().map(|part| part.what);
            all.filter(|what| matches!(what, What::Amplitude(_))).collect()
        };
        let differ = amplitudes(&design);
        design.settle(&white, &differ);
        let freedom = noise[0].freedom + noise[1].freedom;
        // Every part, and the noise.
        let looks = design.parts.len() + 1;
        let mut chosen = choose(&design, &white, freedom, looks);
        let same = design.fit(&white, &[]);
        let shapes: Vec<What> =
            chosen.iter().map(|c| c.what).filter(|w| matches!(w, What::Shape(..))).collect();
        if !shapes.is_empty() {
            design.refine(&white, &[differ, shapes].concat());
        }
        let mut proofs = self.shown(&design, &noise, &unmeasured, &mut chosen);
        let taken: Vec<usize> = chosen.iter().filter_map(|c| design.part(c.what)).collect();
        let fitted = design.fit(&white, &taken);
        self.give_base_to_effects(&design, &fitted, &mut chosen, &mut proofs);
        let mut changes = self.changes(&design, &fitted, &chosen, proofs, freedom);
        changes.extend(self.noise_change(&noise, looks));
        let now = self.split()..self.both.rows.len();
        let left = |fit: &Fitted| -> Vec<f64> {
            let value = fit.value();
            centred(
                &now.clone().zip(&noise[1].clean).map(|(i, clean)| clean - value[i]).collect::<Vec<f64>>(),
            )
        };
        let (left_same, left_changed) = (left(&same), left(&fitted));
        let points = now.clone().zip(left_same.iter().zip(&left_changed));
        let points =
            points.map(|(i, (same, changed))| [self.both.rows.theta[i], *same, same - changed]).collect();
        let would_have_seen = self.would_have_seen(&design, &fitted, &white, noise[1].level, looks);
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
            notes: self.notes,
        };
        Ok(Compared { comparison, points })
    }

    /// Withdraws the parts with which held-out rows of the later recording are not predicted better; the proofs of the others.
    fn shown(
        &mut self,
        design: &Design,
        noise: &[Noise; 2],
        unmeasured: &[usize],
        chosen: &mut Vec<Chosen>,
    ) -> Vec<Option<proof::Proof>> {
        let mut proofs = Vec::new();
        while proofs.len() < chosen.len() {
            let k = proofs.len();
            let taken: Vec<usize> = chosen.iter().filter_map(|c| design.part(c.what)).collect();
            let part = self.of_same_effect(design, chosen, k);
            let proof = proof::prove(design, noise, unmeasured, self.rows(1), &taken, &part);
            if proof.as_ref().is_some_and(|proof| proof.gain.value <= 0.0) {
                let id = self.id(design, chosen[k].what);
                self.notes
                    .push(format!("{id}: a difference is not shown on held-out rows, and is withdrawn"));
                chosen.remove(k);
                proofs.clear();
            } else {
                proofs.push(proof);
            }
        }
        proofs
    }

    /// Where an effect came or went, what differs of the base is taken for a part of it: what an effect refers to (a
    /// temperature, a position at rest) it shares with the base.
    fn give_base_to_effects(
        &mut self,
        design: &Design,
        fitted: &Fitted,
        chosen: &mut Vec<Chosen>,
        proofs: &mut Vec<Option<proof::Proof>>,
    ) {
        let one_sided = |c: &&Chosen| matches!(self.kind(design, fitted, c.what), Kind::Came | Kind::Went);
        let Some(effect) = chosen.iter().find(one_sided).map(|c| self.id(design, c.what)) else { return };
        let of_effects: Vec<bool> =
            chosen.iter().map(|c| !matches!(c.what, What::Gain | What::Base)).collect();
        if of_effects.iter().all(|of| *of) {
            return;
        }
        let (mut a, mut b) = (of_effects.iter(), of_effects.iter());
        chosen.retain(|_| a.next() == Some(&true));
        proofs.retain(|_| b.next() == Some(&true));
        self.notes.push(format!("the base differs as well: it may be a part of {effect}"));
    }

    /// Says where the recordings were taken under other conditions, which may be what changed.
    fn note_ranges(&mut self) {
        for (name, [then, now]) in joined::ranges(self.rows(0), self.rows(1)) {
            if then[1] < now[0] || now[1] < then[0] {
                self.notes.push(format!(
                    "{name} was {:.4} to {:.4} then and is {:.4} to {:.4} now: what changed may be what it does",
                    then[0], then[1], now[0], now[1]
                ));
            }
        }
    }

    /// The chosen parts that belong to the effect of the k-th.
    fn of_same_effect(&self, design: &Design, chosen: &[Chosen], k: usize) -> Vec<usize> {
        let of = |what: What| match what {
            What::Amplitude(k) | What::Shape(k, _) => Some(k),
            _ => None,
        };
        let own = |c: &&Chosen| {
            c.what == chosen[k].what || (of(c.what).is_some() && of(c.what) == of(chosen[k].what))
        };
        chosen.iter().filter(own).filter_map(|c| design.part(c.what)).collect()
    }

    fn id(&self, design: &Design, what: What) -> String {
        match what {
            What::Gain => "gain".into(),
            What::Base => "base".into(),
            What::Amplitude(k) | What::Shape(k, _) => match &design.shared[k].effect {
                None => "structure".into(),
                Some(effect) if !effect.is_form() => effect.id.clone(),
                Some(_) => {
                    let forms =
                        design.shared[..=k].iter().filter(|s| s.effect.as_ref().is_some_and(|e| e.is_form()));
                    format!("empirical_{}", forms.count())
                }
            },
        }
    }

    fn title(&self, design: &Design, what: What) -> String {
        match what {
            What::Gain => "the gain".into(),
            What::Base => "the shape of the base".into(),
            What::Amplitude(k) | What::Shape(k, _) => match &design.shared[k].effect {
                Some(effect) => effect.title.clone(),
                None => "a dependence without a name".into(),
            },
        }
    }

    /// The changes, one of every effect.
    fn changes(
        &self,
        design: &Design,
        fitted: &Fitted,
        chosen: &[Chosen],
        proofs: Vec<Option<proof::Proof>>,
        freedom: f64,
    ) -> Vec<Change> {
        let mut changes: Vec<(f64, Change)> = Vec::new();
        let wide = widening(freedom);
        for (k, proof) in proofs.into_iter().enumerate() {
            let id = self.id(design, chosen[k].what);
            if chosen[..k]
                .iter()
                .any(|c| self.id(design, c.what) == id && same_effect(c.what, chosen[k].what))
            {
                continue;
            }
            let parts = self.of_same_effect(design, chosen, k);
            let mut difference = vec![0.0; self.both.rows.len()];
            for part in &parts {
                let more = fitted.difference(design, *part);
                difference.iter_mut().zip(more).for_each(|(d, m)| *d += m);
            }
            if let What::Amplitude(e) | What::Shape(e, _) = chosen[k].what {
                quantity::add_moved_shape(design, e, &mut difference);
            }
            let later = difference.split_off(self.split());
            let strength = rms(&centred(&later));
            let place = match chosen[k].what {
                What::Gain | What::Base => crate::effects::Place::on("angle_deg"),
                What::Amplitude(e) | What::Shape(e, _) => design.shared[e].place.clone(),
            };
            let alternatives = chosen[k].alternatives.iter().map(|what| self.id(design, *what));
            let mut alternatives: Vec<String> = alternatives.filter(|other| *other != id).collect();
            alternatives.dedup();
            let change = Change {
                kind: self.kind(design, fitted, chosen[k].what),
                title: self.title(design, chosen[k].what),
                place: Some(locate(self.rows(1), &place, &later, 1.0, chosen[k].p_value)),
                p_value: chosen[k].p_value,
                rms: Some(strength),
                parameters: quantity::quantities(design, fitted, chosen[k].what, wide),
                alternatives,
                held_out: proof.map(|p| HeldOut { same: p.without, changed: p.with, gain: p.gain }),
                id,
            };
            changes.push((strength, change));
        }
        changes.sort_by(|a, b| b.0.total_cmp(&a.0));
        changes.into_iter().map(|(_, change)| change).collect()
    }

    /// Whether an effect came, went, or moved: by whether the other recording has it.
    fn kind(&self, design: &Design, fitted: &Fitted, what: What) -> Kind {
        let (What::Amplitude(k) | What::Shape(k, _)) = what else { return Kind::Base };
        let Some(part) = design.part(What::Amplitude(k)) else { return Kind::Moved };
        let present = |recording: usize| {
            design.shared[k].found[recording].is_some()
                || quantity::presence(design, fitted, part, recording) < PRESENT
        };
        match (present(0), present(1)) {
            (false, _) => Kind::Came,
            (true, false) => Kind::Went,
            (true, true) => Kind::Moved,
        }
    }

    /// A change of the noise, where there is one.
    fn noise_change(&self, noise: &[Noise; 2], looks: usize) -> Option<Change> {
        let level = |recording: usize| self.outcomes[recording].diagnosis.noise_floor.value;
        let (ratio, ci95, p) = noise_ratio(noise, [level(0), level(1)]);
        let p_value = (looks as f64 * p).min(1.0);
        (p_value <= FALSE_ALARMS).then(|| Change {
            id: "noise".into(),
            title: if ratio > 1.0 { "more noise".into() } else { "less noise".into() },
            kind: Kind::Noise,
            place: None,
            p_value,
            rms: None,
            parameters: vec![Quantity::ratio("noise now / then", ratio, ci95)],
            alternatives: Vec::new(),
            held_out: None,
        })
    }

    fn would_have_seen(
        &self,
        design: &Design,
        fitted: &Fitted,
        white: &White,
        level: f64,
        looks: usize,
    ) -> Vec<Visible> {
        let mut seen: Vec<Visible> = Vec::new();
        for part in 0..design.parts.len() {
            let what = design.parts[part].what;
            if matches!(what, What::Shape(..)) {
                continue;
            }
            let Some((rms, parameter)) =
                quantity::smallest(design, fitted, white, part, |rank| visible(rank, looks))
            else {
                continue;
            };
            seen.push(Visible { id: self.id(design, what), rms: Some(rms), parameter });
        }
        let now = self.rows(1).len() as f64;
        let power = crate::thresholds::compare::POWER;
        seen.push(Visible {
            id: "new effect".into(),
            rms: Some((HALF_SEEN + power) * level / now.sqrt()),
            parameter: None,
        });
        seen
    }
}

fn same_effect(a: What, b: What) -> bool {
    match (a, b) {
        (What::Amplitude(a) | What::Shape(a, _), What::Amplitude(b) | What::Shape(b, _)) => a == b,
        _ => a == b,
    }
}

/// Half width of a normal 95 % interval.
fn half(error: f64, wide: f64) -> f64 {
    NORMAL_95 * wide * error
}
