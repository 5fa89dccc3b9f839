//! What changed between two recordings of a mechanism in motion. Each is diagnosed by itself. One model of both recordings
//! follows, in which each parameter is the same or differs; where there is none, their parameters are held against each other.

mod apart;
mod best_name;
mod form_names;
mod joined;
mod one_name;

use fitter::plant::Plant;
use numerics::{centred, parallel, rms};

use crate::Verdict;
use crate::diagnosis::Diagnosis;
use crate::dynamic::candidates::{candidates, in_place_of};
use crate::dynamic::data::Data;
use crate::dynamic::diagnose::Identified;
use crate::dynamic::joint::equations::{InEquations, of_one_plant};
use crate::dynamic::joint::feedback::{Inverse, Recorded};
use crate::dynamic::joint::free_run::Known;
use crate::dynamic::model::Model;
use crate::dynamic::search::Augmented;
use crate::dynamic::{Case, DynamicOutcome, DynamicRecording, Options, diagnose, feedback, joint, place};
use crate::error::DiagnosisError;
use crate::thresholds::NORMAL_95;
use crate::thresholds::compare::{CANDIDATES_IN_MOTION, FALSE_ALARMS, SAME_MOTION};
use crate::verdict::{Location, Parameter};

use self::best_name::with_best_name;
use self::form_names::FormNames;
use self::one_name::of_one_name;
use super::alternatives::add_alternatives;
use super::{Change, Comparison, Estimate, Quantity, Side};

/// Compares two recordings of a mechanism: `case` is that of the earlier one.
///
/// # Errors
/// [`DiagnosisError`] where one of them cannot be diagnosed.
pub fn compare(case: &Case, now: &DynamicRecording) -> Result<Comparison, DiagnosisError> {
    let (then, plant) = (case.recording, &case.plant.plant);
    then.comparable(now)?;
    // Under feedback what is estimated depends on how far up the motion is looked at.
    let cutoff_hz = plant.feedback.as_ref().map(|_| feedback::cutoff(then).min(feedback::cutoff(now)));
    let same_motion = same_motion([then, now]);
    let options = Options { cutoff_hz, same_motion, ..case.options.clone() };
    // What came is not in the other recording, which is therefore not held out.
    let of = |recording| diagnose(&Case { recording, held_out: None, options: &options, ..*case });
    let (a, b) = parallel::join(|| of(then), || of(now));
    let (a, b) = (a?, b?);
    let pair = Pair {
        recordings: [then, now],
        plant,
        skip: &case.options.skip,
        names: FormNames::of(&a.identified, &b.identified),
        then: a,
        now: b,
        same_motion,
    };
    Ok(pair.compared())
}

/// Two models, that of one side replaced.
fn with<'m>(mut models: [&'m Model; 2], side: usize, model: &'m Model) -> [&'m Model; 2] {
    models[side] = model;
    models
}

/// Whether both positions go the same way, as where the same move is commanded again.
fn same_motion(recordings: [&DynamicRecording; 2]) -> bool {
    let [then, now] = recordings.map(|recording| &recording.positions[0][..]);
    if then.len().abs_diff(now.len()) as f64 > SAME_MOTION * then.len() as f64 {
        return false;
    }
    let apart: Vec<f64> = then.iter().zip(now).map(|(then, now)| now - then).collect();
    rms(&centred(&apart)) < SAME_MOTION * rms(&centred(then))
}

struct Pair<'a> {
    recordings: [&'a DynamicRecording; 2],
    plant: &'a Plant,
    /// Ids of effects that are left out of the catalogue.
    skip: &'a [String],
    names: FormNames,
    then: DynamicOutcome,
    now: DynamicOutcome,
    /// Whether both follow the same motion.
    same_motion: bool,
}

impl Pair<'_> {
    /// By a model of both where there is one, else by the parameters that both recordings determine.
    fn compared(&self) -> Comparison {
        let joined = match [&self.then.identified, &self.now.identified] {
            [Identified::SecondOrder(a), Identified::SecondOrder(b)] => self.free_run([a, b]),
            [Identified::Inverse(a), Identified::Inverse(b)] => self.inverse([a, b]),
            [Identified::Modes(a), Identified::Modes(b)] => {
                joint::modes::joint(self.recordings, [a, b], self.plant).map(|joint| self.joined(&joint))
            }
            identified => self.in_equations(identified),
        };
        joined.unwrap_or_else(|| self.apart())
    }

    /// By one second-order mechanism that runs free.
    fn free_run(&self, models: [&Model; 2]) -> Option<Comparison> {
        let starts = self.recordings.map(|recording| Data::new(recording).first_states());
        let wider = self.wider();
        let of = |with: [&Model; 2]| {
            let known = |k: usize| Known {
                recording: self.recordings[k],
                own: models[k],
                model: with[k],
                states: &starts[k],
                wider: wider[k],
            };
            joint::free_run::joint([known(0), known(1)], self.plant)
        };
        let rivals = [0, 1].map(|side| self.rivals(side, models));
        let (named, joint) = of_one_name(models, rivals.each_ref().map(Vec::as_slice), of)?;
        let found = [0, 1].map(|k| candidates(self.recordings[k], named[k], self.skip, CANDIDATES_IN_MOTION));
        let joint = with_best_name(joint, &found, |side, model| of(with(named, side, model)));
        Some(self.joined(&joint))
    }

    /// The model of a recording with another name for an effect that it alone has and does not tell from others.
    fn rivals(&self, side: usize, models: [&Model; 2]) -> Vec<Model> {
        let (own, other) = (models[side], models[1 - side]);
        let of_term = |k: usize| {
            let id = own.terms[k].effect.id;
            let effect = self.sides()[side].effects.iter().find(|effect| effect.id == id && !other.has(id));
            effect.map_or_else(Vec::new, |e| in_place_of(self.recordings[side], own, k, &e.alternatives))
        };
        parallel::indices(0..own.terms.len(), of_term).into_iter().flatten().collect()
    }

    /// By one inverse model.
    fn inverse(&self, found: [&Inverse; 2]) -> Option<Comparison> {
        let models = found.map(|found| &found.model);
        let recorded = Recorded::new(self.recordings, found, self.plant, self.same_motion, self.skip);
        let tried = [0, 1].map(|k| recorded.candidates(k, models[k]));
        let of = |side: usize, model: &Model| recorded.joint(with(models, side, model));
        let joint = with_best_name(recorded.joint(models)?, &tried, of);
        Some(self.joined(&joint))
    }

    /// By one plant in equations; none where either recording has none.
    fn in_equations(&self, identified: [&Identified; 2]) -> Option<Comparison> {
        let known = |number: usize| match (identified[number], identified[1 - number]) {
            (Identified::Equations(own), _) => Some(InEquations::clone(own)),
            (Identified::SecondOrder(own), Identified::Equations(other)) => {
                let written = &[&self.then, &self.now][number].plant;
                let recording = self.recordings[number];
                InEquations::of_second_order(written, own.nominal, &other.fitted.model, recording)
            }
            _ => None,
        };
        let [a, b] = [known(0)?, known(1)?];
        let [first, second] = of_one_plant([&a.fitted.model, &b.fitted.model])?;
        let [then, now] = self.recordings.map(|recording| recording.with_inputs(&first.plant.inputs));
        let [of_then, of_now] = self.wider();
        let sides = [
            Known { recording: &then, own: &first, model: &first, states: &a.fitted.states, wider: of_then },
            Known { recording: &now, own: &second, model: &second, states: &b.fitted.states, wider: of_now },
        ];
        joint::free_run::joint(sides, self.plant).map(|joint| self.joined(&joint))
    }

    fn under_feedback(&self) -> bool {
        self.plant.feedback.is_some()
    }

    fn sides(&self) -> [&Diagnosis; 2] {
        [&self.then.diagnosis, &self.now.diagnosis]
    }

    /// By how much the standard errors of each are too small beside structure that is left (Birge's ratio). Under feedback they
    /// allow for it already.
    fn wider(&self) -> [f64; 2] {
        let birge = |d: &Diagnosis| (d.fit.after.train_rms / d.noise_floor.value).max(1.0);
        self.sides().map(|d| if structured(d.verdict) && !self.under_feedback() { birge(d) } else { 1.0 })
    }

    /// What structure that no effect explains does to a comparison of two motions.
    fn of_motions(&self) -> Option<String> {
        let differ = self.under_feedback() && !self.same_motion;
        let what = "the motions differ: what no effect explains may seem to have changed; record the same motion again \
                    to be sure";
        differ.then(|| what.into())
    }

    /// Where a change lives in the later recording.
    fn place(&self, id: &str, p_value: f64) -> Option<Location> {
        place(id, self.recordings[1], p_value)
    }

    /// The comparison in which this changed; `left` is as in [`Comparison`].
    fn of(&self, mut changes: Vec<Change>, left: [f64; 2]) -> Comparison {
        let [then, now] = self.sides();
        add_alternatives(&mut changes, [&then.effects, &now.effects]);
        let unit = if self.under_feedback() { &self.plant.drive_unit } else { &self.plant.position_unit };
        let structured = [then, now].into_iter().zip(self.wider()).filter(|(d, _)| structured(d.verdict));
        let note = |(d, wider): (&Diagnosis, f64)| {
            let errors = if wider > 1.0 {
                format!(
                    "are taken for {wider:.2} times as large, as what is left is so many times the noise: an estimate"
                )
            } else if self.under_feedback() && self.same_motion {
                "are those of the noise, as both follow the same motion".into()
            } else if self.under_feedback() {
                "are by how much parts of the recording disagree".into()
            } else {
                "allow for none of it, as no more is left than noise".into()
            };
            format!("{}: structure is left that no effect explains; standard errors {errors}", d.recording)
        };
        Comparison {
            schema: 1,
            verdict: if changes.is_empty() { "unchanged" } else { "changed" },
            unit: unit.clone(),
            then: Side::of(then),
            now: Side::of(now),
            changes,
            left,
            false_alarms: FALSE_ALARMS,
            would_have_seen: Vec::new(),
            notes: structured.map(note).chain(self.of_motions()).collect(),
        }
    }
}

/// A parameter then and now; `error` is the standard error of its difference.
fn quantity(then: &Parameter, now: &Parameter, error: f64) -> Quantity {
    let estimate = |p: &Parameter| Estimate { value: p.value, ci95: p.ci95 };
    Quantity {
        name: then.name.clone(),
        unit: then.unit.clone(),
        then: Some(estimate(then)),
        now: Some(estimate(now)),
        difference: Some(Estimate::new(now.value - then.value, NORMAL_95 * error)),
    }
}

fn structured(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::PartlyExplained | Verdict::Unexplained)
}
