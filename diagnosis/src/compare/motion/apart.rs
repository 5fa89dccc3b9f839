//! Two recordings of which no model of both can be fitted. The parameters that both determine are held against each other by
//! their intervals. An effect that one recording alone has is not judged: the other may only show it less.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::FALSE_ALARMS;
use crate::thresholds::dynamic::feedback::errors::PARTS;
use crate::verdict::Parameter;

use super::super::choose::visible;
use super::super::{Change, Comparison, Kind, Visible};
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

    /// What changed, by the intervals of both.
    pub(super) fn apart(&self) -> Comparison {
        let both = self.both();
        let tests = both.len().max(1);
        let own = self.sides()[1].fit.after.train_rms;
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
        changes.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        let smallest = |one: &Both| Visible {
            id: one.id.into(),
            rms: None,
            parameter: Some((one.then.name.clone(), visible(1, tests) * one.error())),
        };
        Comparison { would_have_seen: both.iter().map(smallest).collect(), ..self.of(changes, [own; 2]) }
    }
}
