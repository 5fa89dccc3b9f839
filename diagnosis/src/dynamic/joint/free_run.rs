//! A recording of a mechanism that runs free, as one of two: its information is that of the whitened sensitivities.

use fitter::plant::Plant;
use numerics::Symmetric;

use super::expansion::{Evaluation, Expansion};
use super::{Group, Joint, Of, Reported, Side};
use crate::dynamic::accurate::{Refined, estimated_or_coarse};
use crate::dynamic::data::{ALL, CHOOSE, Data, Folds, SCORE};
use crate::dynamic::estimate::{Fitted, fit};
use crate::dynamic::gram::Grams;
use crate::dynamic::noise::autoregression;
use crate::dynamic::recording::DynamicRecording;
use crate::dynamic::search::Augmented;
use crate::thresholds::compare::joint::{ENOUGH, PATIENCE};
use crate::verdict::Location;

/// A model that two recordings may have in common.
pub trait InCommon: Refined + Augmented {
    /// The model of one recording with the effects of both, in the same order for either; none where there is none.
    fn with_effects_of_both(models: [&Self; 2], recording: usize) -> Option<Self>;

    /// The model with the parameters of `own`, and with the amounts at zero of the effects that `own` has not; none where it has
    /// them all.
    fn beside(&self, own: &Self) -> Option<Self>;

    /// The model with nothing but its initial states free.
    fn fixed(&self) -> Self;

    /// As [`Side::groups`].
    fn groups(&self) -> Vec<Group>;

    /// As [`Side::readings`].
    fn readings(&self, of: Of, plant: &Plant) -> Vec<Reported>;

    /// As [`Side::amounts`].
    fn amounts(&self, of: Of) -> Vec<usize>;

    /// As [`Side::is_plausible`]; a user's effects are what the user says.
    fn is_plausible(&self, _of: Of, _data: &Data) -> bool {
        true
    }

    /// As [`Side::place`].
    fn place(&self, group: &Group, recording: &DynamicRecording, p_value: f64) -> Option<Location>;
}

/// See the module.
pub struct FreeRun<'a, M: InCommon> {
    recording: &'a DynamicRecording,
    plant: &'a Plant,
    data: Data<'a>,
    fitted: Fitted<M>,
    /// Which rows it is fitted to.
    folds: Folds,
    noise: Noise,
    own: Expansion,
    deviance: f64,
    /// For how many times as large errors are taken as the noise says.
    wider: f64,
}

/// The noise of a recording.
#[derive(Clone)]
struct Noise {
    /// Its autoregression.
    coefficients: Vec<f64>,
    /// Its variance, as it is taken.
    variance: f64,
}

/// One of the recordings and what is known of it.
pub struct Known<'a, 'm, M: InCommon> {
    /// The recording.
    pub recording: &'a DynamicRecording,
    /// The model that its own diagnosis found.
    pub own: &'m M,
    /// The same, or with one effect more.
    pub model: &'m M,
    /// Where its runs begin.
    pub states: &'m [M::Start],
    /// For how many times as large errors are taken as the noise says.
    pub wider: f64,
}

/// A model of both recordings; none where one of them cannot be fitted with the effects of both.
pub fn joint<'a, M: InCommon>(
    sides: [Known<'a, '_, M>; 2],
    plant: &'a Plant,
) -> Option<Joint<FreeRun<'a, M>>> {
    let models = [sides[0].model, sides[1].model];
    let of = |number: usize| FreeRun::of(&sides[number], models, number, plant);
    let (then, now) = numerics::parallel::join(|| of(0), || of(1));
    let (then, now) = (then?, now?);
    let same = then.fitted.model.packed().len() == now.fitted.model.packed().len();
    same.then(|| Joint::new(then, now))
}

impl<'a, M: InCommon> FreeRun<'a, M> {
    fn of(known: &Known<'a, '_, M>, models: [&M; 2], number: usize, plant: &'a Plant) -> Option<Self> {
        let data = Data::new(known.recording);
        let union = M::with_effects_of_both(models, number)?;
        // From its own model a fit with more effects is never the worse one.
        let beside = union.beside(known.own);
        let starts = [Some(union), beside];
        let fits =
            starts.iter().flatten().filter_map(|model| estimated_or_coarse(model, known.states, &data, ALL));
        let fitted = fits.min_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)))?;
        let Known { recording, wider, .. } = *known;
        FreeRun::fitted(recording, plant, data, fitted, ALL, wider)
    }

    /// As it was fitted to some rows; structure that is left makes errors `wider`.
    fn fitted(
        recording: &'a DynamicRecording,
        plant: &'a Plant,
        data: Data<'a>,
        fitted: Fitted<M>,
        folds: Folds,
        wider: f64,
    ) -> Option<Self> {
        let coefficients = autoregression(&fitted.residual(&data)?, &data.runs).coefficients;
        let whole = fitted.model.normal(&fitted.states, &data, &coefficients).ok()?;
        let rows = whole.rows(folds).max(1) as f64;
        let reduced = whole.reduced(folds, 0.0, &[]);
        let square = reduced.at(reduced.size - 1, reduced.size - 1) / rows;
        let noise = Noise { coefficients, variance: wider * wider * square };
        let own = expansion(&reduced, noise.variance)?;
        let deviance = rows * square.ln() / (wider * wider);
        Some(FreeRun { recording, plant, data, fitted, folds, noise, own, deviance, wider })
    }

    /// The normal equations at some packed parameters, with the initial states that fit best with these, and the fall of the cost
    /// that a further step of the states promises and does not bring; none where the model cannot be simulated.
    fn normal(&self, packed: &[f64]) -> Option<(Grams, f64)> {
        let model = self.fitted.model.unpacked(packed);
        let at = |states: &[M::Start]| model.normal(states, &self.data, &self.noise.coefficients).ok();
        let moved = |states: &[M::Start], by: &[Vec<f64>]| -> Vec<M::Start> {
            states.iter().zip(by).map(|(state, by)| model.moved(state, by)).collect()
        };
        let mut states = self.fitted.states.clone();
        let mut whole = at(&states)?;
        for _ in 0..PATIENCE {
            let (by, promised) = whole.step_of_states(self.folds);
            if promised < ENOUGH * self.noise.variance {
                return Some((whole, 0.0));
            }
            let next = moved(&states, &by);
            match at(&next).filter(|there| there.cost(self.folds) < whole.cost(self.folds)) {
                Some(there) => (states, whole) = (next, there),
                None => return Some((whole, promised)),
            }
        }
        let (_, promised) = whole.step_of_states(self.folds);
        Some((whole, promised))
    }
}

/// What normal equations without the initial states say about the parameters, in units of the noise of this variance: the
/// states follow the parameters, in the cost as in its slope. None where it is not finite.
fn expansion(reduced: &Symmetric, variance: f64) -> Option<Expansion> {
    let free = reduced.size - 1;
    let of = |k: usize| reduced.at(k, free) / variance;
    let mut information = reduced.part(0..free);
    information.entries.iter_mut().for_each(|entry| *entry /= variance);
    let expansion = Expansion { cost: of(free), pull: (0..free).map(of).collect(), information };
    expansion.is_finite().then_some(expansion)
}

impl<M: InCommon> Side for FreeRun<'_, M> {
    fn groups(&self) -> Vec<Group> {
        self.fitted.model.groups()
    }

    fn packed(&self) -> Vec<f64> {
        self.fitted.model.packed()
    }

    fn evaluate(&self, packed: &[f64]) -> Option<Evaluation<'_>> {
        let (whole, not_reached) = self.normal(packed)?;
        let mut there = expansion(&whole.reduced(self.folds, 0.0, &[]), self.noise.variance)?;
        there.cost += not_reached / self.noise.variance;
        Some(there.into())
    }

    fn own(&self) -> &Expansion {
        &self.own
    }

    fn deviance(&self) -> f64 {
        self.deviance
    }

    /// Twice: a change of six standard errors is seen in one quarter of the rows with three, and one in fifteen of these seems
    /// to predict nothing there.
    fn held_out(&self) -> &'static [usize] {
        &[SCORE, CHOOSE]
    }

    fn without(&self, kind: usize) -> Option<Self> {
        let others = std::array::from_fn(|other| other != kind);
        let fitted = estimated_or_coarse(&self.fitted.model, &self.fitted.states, &self.data, others)?;
        FreeRun::fitted(self.recording, self.plant, self.data.clone(), fitted, others, self.wider)
    }

    fn left(&self, packed: &[f64], folds: Folds) -> Option<Vec<f64>> {
        let model = self.fitted.model.unpacked(packed).fixed();
        fit(&model, &self.fitted.states, &self.data, folds)?.residual(&self.data)
    }

    fn noise(&self) -> f64 {
        self.fitted.rms(self.folds)
    }

    fn data(&self) -> &Data<'_> {
        &self.data
    }

    fn readings(&self, of: Of, packed: &[f64]) -> Vec<Reported> {
        self.fitted.model.unpacked(packed).readings(of, self.plant)
    }

    fn amounts(&self, of: Of) -> Vec<usize> {
        self.fitted.model.amounts(of)
    }

    fn sought(&self, of: Of) -> usize {
        let Of::Term(k) = of else { return 1 };
        M::starts(M::effect(&self.fitted.model.terms()[k]), &self.data).len()
    }

    fn is_plausible(&self, of: Of, packed: &[f64]) -> bool {
        self.fitted.model.unpacked(packed).is_plausible(of, &self.data)
    }

    fn place(&self, group: &Group, p_value: f64) -> Option<Location> {
        self.fitted.model.place(group, self.recording, p_value)
    }
}
