//! Two recordings of which no model of both can be fitted. The parameters that both determine are held
//! against each other by their intervals; an effect that one recording alone has came or went.

use std::collections::BTreeSet;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::FALSE_ALARMS;
use crate::thresholds::dynamic::feedback::errors::PARTS;
use crate::verdict::{NamedEffect, Parameter};

use super::super::choose::visible;
use super::super::{Change, Comparison, Estimate, Kind, Quantity, Visible};
use super::{Pair, quantity};

/// A parameter that both recordings determine.
struct Both<'a> {
    id: &'a str,
    title: String,
    then: &'a Parameter,
    now: &'a Parameter,
    /// How many times its standard error each is taken for.
    wider: [f64; 2],
}

/// The p-value of a difference of so many standard errors, each known at least as well as from so many parts of a recording.
fn two_sided(z: f64) -> f64 {
    StudentsT::new(0.0, 1.0, 2.0 * (PARTS as f64 - 1.0)).map_or(1.0, |t| 2.0 * t.sf(z))
}

impl Both<'_> {
    /// The difference in joint standard errors.
    fn z(&self) -> f64 {
        (self.now.value - self.then.value).abs() / self.error().max(f64::MIN_POSITIVE)
    }

    fn error(&self) -> f64 {
        let error = |p: &Parameter| 0.5 * (p.ci95[1] - p.ci95[0]) / NORMAL_95;
        (self.wider[0] * error(self.then)).hypot(self.wider[1] * error(self.now))
    }
}

impl Pair<'_> {
    /// What both determine: the plant's parameters, each for itself, and those of the effects that both have.
    fn both(&self) -> Vec<Both<'_>> {
        let [then, now] = self.sides();
        let wider = self.wider();
        let of_name = |name: &str, all: &'_ [Parameter]| all.iter().position(|p| p.name == name);
        let plant = then.plant.iter().filter_map(|p| {
            let other = &now.plant[of_name(&p.name, &now.plant)?];
            Some(Both {
                id: &p.name,
                title: format!("the {} of the plant", p.name),
                then: p,
                now: other,
                wider,
            })
        });
        let mut both: Vec<Both> = plant.collect();
        for e in &then.effects {
            let Some(other) = now.effects.iter().find(|other| other.id == e.id) else { continue };
            let pairs = e.parameters.iter().filter_map(|p| Some((p, of_name(&p.name, &other.parameters)?)));
            both.extend(pairs.map(|(then, k)| {
                let now = &other.parameters[k];
                Both { id: &e.id, title: e.title.clone(), then, now, wider }
            }));
        }
        both
    }

    /// The effects that one recording alone has.
    fn alone(&self, recording: usize) -> Vec<&NamedEffect> {
        let sides = self.sides();
        let other: BTreeSet<&str> = sides[1 - recording].effects.iter().map(|e| e.id.as_str()).collect();
        sides[recording].effects.iter().filter(|e| !other.contains(e.id.as_str())).collect()
    }

    /// What changed, by the intervals of both.
    pub(super) fn apart(&self) -> Comparison {
        let both = self.both();
        let tests = (both.len() + self.alone(0).len() + self.alone(1).len()).max(1);
        let [then, now] = self.sides();
        // The later recording by the earlier one's model, and by its own.
        let own = now.fit.after.train_rms;
        let of_now = then.fit.held_out_by == now.recording;
        let left = [then.fit.after.held_out_rms.filter(|_| of_now).unwrap_or(own), own];
        let mut changes: Vec<Change> = Vec::new();
        let ids: Vec<&str> = both.iter().fold(Vec::new(), |mut ids, one| {
            if !ids.contains(&one.id) {
                ids.push(one.id);
            }
            ids
        });
        for id in ids {
            let of: Vec<&Both> = both.iter().filter(|one| one.id == id).collect();
            let z = of.iter().map(|one| one.z()).fold(0.0, f64::max);
            let p_value = (tests as f64 * two_sided(z)).min(1.0);
            if p_value <= FALSE_ALARMS {
                changes.push(Change {
                    id: id.into(),
                    title: of[0].title.clone(),
                    kind: Kind::Moved,
                    place: self.place(id, p_value),
                    p_value,
                    rms: None,
                    parameters: of.iter().map(|one| quantity(one.then, one.now, one.error())).collect(),
                    alternatives: Vec::new(),
                    held_out: None,
                });
            }
        }
        for (recording, kind) in [(1, Kind::Came), (0, Kind::Went)] {
            // What came or went must show where the earlier model meets the later recording.
            let found = self.alone(recording).into_iter();
            let found = found.filter(|e| own < left[0] && tests as f64 * e.p_value <= FALSE_ALARMS);
            changes.extend(found.map(|e| self.one_sided(e, recording, kind, tests)));
        }
        changes.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        let smallest = |one: &Both| Visible {
            id: one.id.into(),
            rms: None,
            parameter: Some((one.then.name.clone(), visible(1, tests) * one.error())),
        };
        Comparison { would_have_seen: both.iter().map(smallest).collect(), ..self.of(changes, left) }
    }

    fn one_sided(&self, e: &NamedEffect, recording: usize, kind: Kind, tests: usize) -> Change {
        let of = |p: &Parameter| {
            let estimate = Some(Estimate { value: p.value, ci95: p.ci95 });
            let (then, now) = if recording == 0 { (estimate, None) } else { (None, estimate) };
            Quantity { name: p.name.clone(), unit: p.unit.clone(), then, now, difference: None }
        };
        let p_value = (tests as f64 * e.p_value).min(1.0);
        Change {
            id: e.id.clone(),
            title: e.title.clone(),
            kind,
            place: self.place(&e.id, p_value),
            p_value,
            rms: None,
            parameters: e.parameters.iter().map(of).collect(),
            alternatives: e.alternatives.clone(),
            held_out: None,
        }
    }
}
