//! A recording under feedback, as one of two: the inverse model of either has the effects of both, along motions that are
//! smoothed alike. Shapes are those of the recording in which the effect was found; its amounts may differ.

use std::sync::Arc;

use fitter::plant::Plant;
use numerics::parallel;

use super::expansion::Expansion;
use super::second_order::{is_per_inertia, readings};
use super::{Gradient, Group, Joint, Of, Side};
use crate::dynamic::candidates::Candidates;
use crate::dynamic::data::{Data, Folds, SCORE};
use crate::dynamic::effects::{CATALOGUE, DynamicEffect, Part, Reading};
use crate::dynamic::feedback::errors::covariance;
use crate::dynamic::feedback::inverse::{Solved, predict, solve};
use crate::dynamic::feedback::motion::Motion;
use crate::dynamic::feedback::search::Along;
use crate::dynamic::feedback::usual_terms;
use crate::dynamic::interval::Sort;
use crate::dynamic::model::{Model, Term};
use crate::dynamic::recording::DynamicRecording;
use crate::dynamic::verdict::{PLANT, nominal, place};
use crate::thresholds::dynamic::feedback::errors::{PARTS, SMOOTHER};
use crate::verdict::{Location, Parameter};

/// What was found along a motion: the inverse model, up to which frequency, and below which speed it stands still.
#[derive(Clone)]
pub struct Inverse {
    /// The model.
    pub model: Model,
    /// The cut-off of the smoothing, Hz.
    pub cutoff_hz: f64,
    /// The speed.
    pub slow: f64,
}

/// See the module.
#[derive(Clone)]
pub struct UnderFeedback<'a> {
    recording: &'a DynamicRecording,
    plant: &'a Plant,
    data: Data<'a>,
    motions: Arc<Motions>,
    solved: Solved,
    packed: Vec<f64>,
    own: Expansion,
}

/// The motion of a recording.
struct Motions {
    motion: Motion,
    /// The same up to a part of its cut-off. The reading noise is in the drive and in the motion: it moves the estimates, more so
    /// the higher one looks. None where the other recording follows the same motion, and they are moved alike.
    smoother: Option<Motion>,
}

/// Two recordings under feedback, their motions smoothed alike.
pub struct Recorded<'a> {
    recordings: [&'a DynamicRecording; 2],
    plant: &'a Plant,
    motions: [Arc<Motions>; 2],
    /// Ids of effects that are left out of the catalogue.
    skip: &'a [String],
}

impl<'a> Recorded<'a> {
    /// Up to the lower cut-off of both, and standing still below the higher speed.
    pub fn new(
        recordings: [&'a DynamicRecording; 2],
        found: [&Inverse; 2],
        plant: &'a Plant,
        same_motion: bool,
        skip: &'a [String],
    ) -> Recorded<'a> {
        let slow = found[0].slow.max(found[1].slow);
        let cutoff_hz = found[0].cutoff_hz.min(found[1].cutoff_hz);
        let motions = recordings.map(|recording| {
            let motion = |cutoff_hz: f64| Motion::new(recording, cutoff_hz, Some(slow));
            let smoother = (!same_motion).then(|| motion(SMOOTHER * cutoff_hz));
            Motions { motion: motion(cutoff_hz), smoother }.into()
        });
        Recorded { recordings, plant, motions, skip }
    }

    /// A model of both with the effects of two; none where one of the recordings does not determine it.
    pub fn joint(&self, models: [&Model; 2]) -> Option<Joint<UnderFeedback<'a>>> {
        let of = |number: usize, shapes: &Model| {
            let motions = self.motions[number].clone();
            UnderFeedback::of(self.recordings[number], self.plant, motions, shapes, &|_| true)
        };
        let mut usual = usual_terms(self.recordings[0]);
        usual.retain(|term| self.in_question(term.effect));
        let with = |first: usize| {
            let shapes = with_effects_of_both(models[first], models[1 - first], &usual);
            let (then, now) = parallel::join(|| of(0, &shapes), || of(1, &shapes));
            Some([then?, now?])
        };
        let left = |[then, now]: &[UnderFeedback; 2]| then.mean_square().ln() + now.mean_square().ln();
        let both = [0, 1].into_iter().filter_map(with).min_by(|a, b| left(a).total_cmp(&left(b)));
        both.map(|[then, now]| Joint::new(then, now))
    }

    fn in_question(&self, effect: &DynamicEffect) -> bool {
        self.skip.iter().all(|id| id != effect.id)
    }

    /// The effects of the catalogue beside the model of one of them.
    pub fn candidates(&self, number: usize, model: &Model) -> Candidates {
        let data = Data::new(self.recordings[number]);
        let motion = &self.motions[number].motion;
        let along = Along { motion, fold: &data.fold, per_row: motion.independent_per_row() };
        let catalogue: Vec<&'static DynamicEffect> =
            CATALOGUE.iter().copied().filter(|effect| self.in_question(effect)).collect();
        let present = along.fit(model);
        let found = present.map(|present| along.contenders(&present, &catalogue, &data.scale));
        let models = found.into_iter().flatten().map(|solved| solved.model).collect();
        Candidates { models, sought: catalogue.len() }
    }
}

/// A model with the effects of both, of two that cannot be told apart the first one's; and with what every drive has some of.
/// Neither recording may show it by itself, but left out it moves the others, and by how much depends on the motion.
fn with_effects_of_both(first: &Model, second: &Model, usual: &[Term]) -> Model {
    let mut union = first.clone();
    union.nominal_free[1] = true;
    let constant = |effect: &DynamicEffect| matches!(effect.part, Part::Drive | Part::SensorOffset);
    for term in second.terms.iter().chain(usual) {
        let alike = |known: &Term| {
            let (a, b) = (known.effect, term.effect);
            let same = |is: &dyn Fn(&DynamicEffect) -> bool| is(a) && is(b);
            a.id == b.id || same(&DynamicEffect::is_late) || same(&constant) || same(&|e| e.creeps)
        };
        if !union.terms.iter().any(alike) {
            union.terms.push(term.clone());
        }
    }
    union
}

impl<'a> UnderFeedback<'a> {
    fn of(
        recording: &'a DynamicRecording,
        plant: &'a Plant,
        motions: Arc<Motions>,
        shapes: &Model,
        wanted: &dyn Fn(usize) -> bool,
    ) -> Option<UnderFeedback<'a>> {
        let Motions { motion, smoother } = &*motions;
        let solved = solve(shapes, motion, wanted)?;
        let lanes = lanes(&solved.model);
        let values = |model: &Model| -> Vec<f64> {
            lanes.iter().map(|lane| *value(&mut model.clone(), *lane)).collect()
        };
        let packed = values(&solved.model);
        let mut covariance = covariance(&solved, motion, smoother.is_none(), wanted, &lanes);
        if let Some(smoother) = smoother {
            let there = values(&solve(shapes, smoother, wanted)?.model);
            let moved: Vec<f64> = there.iter().zip(&packed).map(|(there, here)| there - here).collect();
            for (i, a) in moved.iter().enumerate() {
                moved.iter().enumerate().for_each(|(j, b)| *covariance.at_mut(i, j) += a * b);
            }
        }
        // The inverse model is linear: its fit says all.
        let information = covariance.factor().inverse();
        let own = Expansion { cost: 0.0, pull: vec![0.0; lanes.len()], information };
        let finite = own.is_finite() && packed.iter().all(|value| value.is_finite());
        let data = Data::new(recording);
        finite.then_some(UnderFeedback { recording, plant, data, motions, solved, packed, own })
    }

    fn mean_square(&self) -> f64 {
        numerics::rms(&self.solved.residual).powi(2)
    }

    fn with(&self, packed: &[f64]) -> Model {
        let mut model = self.solved.model.clone();
        lanes(&model).into_iter().zip(packed).for_each(|(lane, to)| *value(&mut model, lane) = *to);
        model
    }

    fn lanes_of(&self, k: usize) -> Vec<Option<usize>> {
        let lanes = lanes(&self.solved.model);
        let of = |j: usize| lanes.iter().position(|lane| *lane == Lane::Term(k, j));
        (0..self.solved.model.terms[k].parameters.len()).map(of).collect()
    }
}

/// A parameter that is fitted: of the plant, or of a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Damping (0), stiffness (1) or gain (2).
    Plant(usize),
    /// Of this term this parameter.
    Term(usize, usize),
}

/// The parameters of an inverse model that are fitted: all but shapes.
fn lanes(model: &Model) -> Vec<Lane> {
    let plant = (0..3).filter(|k| *k != 1 || model.nominal_free[1]).map(Lane::Plant);
    let of_terms = model.terms.iter().enumerate().flat_map(|(k, term)| {
        let effect = term.effect;
        let fitted = move |j: &usize| match effect.part {
            Part::Force => !effect.parameters[*j].shape,
            _ => *j == 0,
        };
        (0..term.parameters.len()).filter(fitted).map(move |j| Lane::Term(k, j))
    });
    plant.chain(of_terms).collect()
}

fn value(model: &mut Model, lane: Lane) -> &mut f64 {
    match lane {
        Lane::Plant(k) => &mut model.nominal[k],
        Lane::Term(k, j) => &mut model.terms[k].parameters[j],
    }
}

impl Side for UnderFeedback<'_> {
    fn groups(&self) -> Vec<Group> {
        let model = &self.solved.model;
        let lanes = lanes(model);
        let plant = lanes.iter().enumerate().filter_map(|(lane, of)| {
            let Lane::Plant(k) = *of else { return None };
            Some(Group::of_lanes(PLANT[k][0], PLANT[k][1], [lane], Of::Plant(k)))
        });
        let effects = model.terms.iter().enumerate().map(|(k, term)| {
            let lanes = self.lanes_of(k).into_iter().flatten();
            Group::of_lanes(term.effect.id, term.effect.title, lanes, Of::Term(k))
        });
        let per_inertia = |lane: &usize| match lanes[*lane] {
            Lane::Plant(_) => true,
            Lane::Term(k, j) => is_per_inertia(&model.terms[k], j),
        };
        let inertia = Group::of_inertia(&self.packed, (0..lanes.len()).filter(per_inertia));
        let special_cases = Group::of_special_cases(&model.terms, |k| self.lanes_of(k)[0]);
        plant.chain(effects).chain(special_cases).chain(inertia).collect()
    }

    fn packed(&self) -> Vec<f64> {
        self.packed.clone()
    }

    fn expanded(&self, packed: &[f64]) -> Option<Expansion> {
        Some(self.by_own_fit(packed))
    }

    fn own(&self) -> &Expansion {
        &self.own
    }

    /// Of a real drive a better fit says nothing of a change: it always has structure that no model explains.
    fn deviance(&self) -> f64 {
        0.0
    }

    /// Parts of the recording say how uncertain its estimates are.
    fn freedom(&self) -> Option<f64> {
        Some(PARTS as f64 - 1.0)
    }

    fn unscored(&self) -> Option<Self> {
        let wanted = |row: usize| usize::from(self.data.fold[row]) != SCORE;
        let (motions, model) = (self.motions.clone(), &self.solved.model);
        UnderFeedback::of(self.recording, self.plant, motions, model, &wanted)
    }

    fn left(&self, packed: &[f64], _: Folds) -> Option<Vec<f64>> {
        let motion = &self.motions.motion;
        let predicted = motion.smooth(&predict(&self.with(packed), motion));
        Some(motion.drive.iter().zip(&predicted).map(|(drive, predicted)| drive - predicted).collect())
    }

    fn noise(&self) -> f64 {
        self.mean_square().sqrt()
    }

    fn data(&self) -> &Data<'_> {
        &self.data
    }

    fn readings(&self, of: Of, packed: &[f64]) -> Vec<(Parameter, Gradient, Sort)> {
        let model = self.with(packed);
        match of {
            Of::Plant(k) => {
                let lane = lanes(&model).iter().position(|lane| *lane == Lane::Plant(k));
                let parameter = nominal(model.nominal, [0.0; 3], self.plant).swap_remove(k);
                vec![(parameter, lane.map(|lane| (lane, 1.0)).into_iter().collect(), Sort::Amount)]
            }
            Of::Term(k) => {
                let plain = |reading: &Reading, _: &Term| reading.gradient.clone();
                readings(&model.terms[k], &self.lanes_of(k), plain, self.plant)
            }
            Of::Inertia => Vec::new(),
        }
    }

    fn amounts(&self, of: Of) -> Vec<usize> {
        let Of::Term(k) = of else { return Vec::new() };
        self.lanes_of(k).into_iter().flatten().collect()
    }

    fn place(&self, group: &Group, p_value: f64) -> Option<Location> {
        place(&group.id, self.recording, p_value)
    }
}
