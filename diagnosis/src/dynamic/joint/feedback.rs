//! A recording under feedback, as one of two: the inverse model of either has the effects of both, along motions that are
//! smoothed alike. Shapes are those of both, near those of the recording in which the effect was found; its amounts may differ.
//!
//! What differs are coefficients of the drive, of which the model is a sum: inertia times acceleration, and so on. Parameters
//! per inertia, which are reported, are as uncertain as the inertia, and a slow motion hardly shows that.

use std::sync::Arc;

use fitter::plant::Plant;
use numerics::parallel;

use super::coefficients::{self, Linearised, coefficients, is_shape, of_one, owners, polished};
use super::expansion::{Evaluation, Expansion};
use super::second_order::readings;
use super::{Gradient, Group, INERTIA, INERTIA_TITLE, Joint, Of, Reported, Side};
use crate::dynamic::candidates::Candidates;
use crate::dynamic::data::{Data, Folds};
use crate::dynamic::effects::{DynamicEffect, Part, Reading, under_feedback};
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
use crate::thresholds::dynamic::feedback::search::LEAST_PART;
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
    /// What the packed parameters leave.
    residual: Vec<f64>,
    /// The coefficients of the drive, then the shapes.
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
        let polished = [0, 1].map(|k| polished(models[k], &self.motions[k].motion));
        let with = |first: usize| {
            let shapes = with_effects_of_both(&polished[first], &polished[1 - first], &usual);
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
            under_feedback().filter(|effect| self.in_question(effect)).collect();
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
        let own = Linearised::of(shapes, motion, wanted)?;
        let rows: Vec<usize> = motion.rows().filter(|row| wanted(*row)).collect();
        let mut covariance = covariance(&own.columns, &own.residual, motion, smoother.is_none(), &rows);
        if let Some(smoother) = smoother {
            // With the same shapes, which the smoother motion hardly shows.
            let [here, there] =
                [&own.solved.model, &solve(shapes, smoother, wanted)?.model].map(coefficients);
            let moved: Vec<f64> = there.iter().zip(&here).map(|(there, here)| there - here).collect();
            for (i, a) in moved.iter().enumerate() {
                moved.iter().enumerate().for_each(|(j, b)| *covariance.at_mut(i, j) += a * b);
            }
        }
        let Linearised { solved, packed, residual, .. } = own;
        // The inverse model is linear but for shapes near their own: its fit says all.
        let information = covariance.factor().inverse();
        let own = Expansion { cost: 0.0, pull: vec![0.0; packed.len()], information };
        let finite = own.is_finite() && packed.iter().all(|value| value.is_finite());
        let data = Data::new(recording);
        finite.then_some(UnderFeedback { recording, plant, data, motions, solved, residual, packed, own })
    }

    fn mean_square(&self) -> f64 {
        self.motions.motion.rms(&self.residual).powi(2)
    }

    /// The model with these packed parameters.
    fn with(&self, packed: &[f64]) -> Model {
        coefficients::with(&self.solved.model, packed)
    }

    /// Number of coefficients of the mechanism without effects.
    fn nominal(&self) -> usize {
        2 + usize::from(self.solved.model.nominal_free[1])
    }

    fn lanes_of(&self, k: usize) -> Vec<Option<usize>> {
        let owners = owners(&self.solved.model);
        let of = |j: usize| owners.iter().find(|(_, owner)| *owner == (k, j)).map(|(lane, _)| *lane);
        (0..self.solved.model.terms[k].parameters.len()).map(of).collect()
    }

    /// The packed parameters that multiply a term.
    fn amounts_of(&self, k: usize) -> impl Iterator<Item = usize> {
        let effect = self.solved.model.terms[k].effect;
        let lanes = self.lanes_of(k).into_iter().enumerate();
        lanes.filter(|(j, _)| !is_shape(effect, *j)).filter_map(|(_, lane)| lane)
    }

    /// How fast what is `slope` times an amount of a term, at `lane`, changes with the coefficients.
    fn by_coefficients(model: &Model, k: usize, (lane, slope): (usize, f64), amount: f64) -> Gradient {
        let of_one = of_one(model, k);
        let [_, stiffness, gain] = model.nominal;
        match model.terms[k].effect.part {
            Part::Force => vec![(lane, slope * of_one), (0, -slope * amount * gain)],
            Part::SensorOffset if stiffness != 0.0 => {
                vec![(lane, slope * of_one), (2, -slope * amount * of_one)]
            }
            _ => vec![(lane, slope)],
        }
    }
}

impl Side for UnderFeedback<'_> {
    fn groups(&self) -> Vec<Group> {
        let model = &self.solved.model;
        let inertia = Group::of_lanes(INERTIA, INERTIA_TITLE, [0], Of::Inertia);
        let plant = (1..self.nominal())
            .map(|k| Group::of_lanes(PLANT[k - 1][0], PLANT[k - 1][1], [k], Of::Plant(k - 1)));
        let effects = model.terms.iter().enumerate().map(|(k, term)| {
            Group::of_lanes(term.effect.id, term.effect.title, self.amounts_of(k), Of::Term(k))
        });
        // A stronger drive needs less of all that the mechanism does.
        let mechanical = |k: &usize| model.terms[*k].effect.part == Part::Force;
        let forces = (0..model.terms.len()).filter(mechanical).flat_map(|k| self.amounts_of(k));
        let falls: Vec<(usize, f64)> =
            (0..self.nominal()).chain(forces).map(|lane| (lane, -self.packed[lane])).collect();
        let gain = Group {
            id: PLANT[2][0].into(),
            title: PLANT[2][1].into(),
            directions: vec![falls],
            of: Of::Plant(2),
        };
        let special_cases = Group::of_special_cases(&model.terms, |k| self.lanes_of(k)[0]);
        plant.chain([gain]).chain(effects).chain(special_cases).chain([inertia]).collect()
    }

    fn packed(&self) -> Vec<f64> {
        self.packed.clone()
    }

    fn evaluate(&self, packed: &[f64]) -> Option<Evaluation<'_>> {
        Some(self.by_own_fit(packed).into())
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

    fn without(&self, kind: usize) -> Option<Self> {
        let wanted = |row: usize| usize::from(self.data.fold[row]) != kind;
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

    fn readings(&self, of: Of, packed: &[f64]) -> Vec<Reported> {
        let model = self.with(packed);
        let gain = model.nominal[2];
        match of {
            Of::Plant(k) => {
                let parameter = nominal(model.nominal, [0.0; 3], self.plant).swap_remove(k);
                let gradient = match k {
                    2 => vec![(0, -gain * gain)],
                    _ => vec![(k + 1, gain), (0, -model.nominal[k] * gain)],
                };
                vec![(parameter, gradient, Sort::Amount)]
            }
            Of::Term(k) => {
                let lanes = self.lanes_of(k);
                let plain = |reading: &Reading, _: &Term| reading.gradient.clone();
                let all = readings(&model.terms[k], &lanes, plain, self.plant);
                let by_coefficients = |(parameter, gradient, sort): (Parameter, Gradient, Sort)| {
                    let of = |(lane, slope): (usize, f64)| {
                        let term = &model.terms[k];
                        match lanes.iter().position(|own| *own == Some(lane)) {
                            Some(j) if !is_shape(term.effect, j) => {
                                Self::by_coefficients(&model, k, (lane, slope), term.parameters[j])
                            }
                            _ => vec![(lane, slope)],
                        }
                    };
                    (parameter, gradient.into_iter().flat_map(of).collect(), sort)
                };
                all.into_iter().map(by_coefficients).collect()
            }
            Of::Inertia | Of::Structure(_) => Vec::new(),
        }
    }

    fn ratio(&self, of: Of, then: &[f64], length: f64, error: f64) -> Option<(f64, f64)> {
        matches!(of, Of::Inertia).then(|| (1.0 + length / then[0], error / then[0].abs()))
    }

    fn is_plausible(&self, of: Of, packed: &[f64]) -> bool {
        let Of::Term(k) = of else { return true };
        let term = &self.with(packed).terms[k];
        (term.effect.plausible)(&term.parameters, &self.data.scale)
    }

    /// Along different motions as much as an effect: what no effect explains makes small differences.
    fn least_part(&self) -> f64 {
        if self.motions.smoother.is_some() { LEAST_PART } else { 0.0 }
    }

    fn counts(&self, row: usize) -> bool {
        self.motions.motion.moving[row]
    }

    fn amounts(&self, of: Of) -> Vec<usize> {
        let Of::Term(k) = of else { return Vec::new() };
        self.amounts_of(k).collect()
    }

    fn place(&self, group: &Group, p_value: f64) -> Option<Location> {
        place(&group.id, self.recording, p_value)
    }
}
