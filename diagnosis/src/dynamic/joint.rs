//! One model of two recordings of a mechanism that runs free: every parameter is the same in both, or differs.
//!
//! Each recording is fitted by a model with the effects of both, and says how well it determines which parameters: its
//! information, from the whitened sensitivities. To first order about both fits, that is all that a model of both needs.

use std::ops::Range;

use fitter::plant::Plant;
use numerics::{Symmetric, parallel, rms};

use super::data::{ALL, Data, Folds, SCORE, UNSCORED};
use super::diagnose::residual;
use super::effects::{Reading, unit_of};
use super::estimate::{Fitted, Simulated, fit};
use super::interval::{Sort, around};
use super::model::{Model, Term};
use super::noise::autoregression;
use super::recording::DynamicRecording;
use super::verdict::{PLANT, nominal, slopes, sort};
use crate::calibrate::log_tail;
use crate::verdict::Parameter;

/// What may differ: a parameter of the plant, or an effect.
pub struct Group {
    /// `damping`, `stiffness`, `gain`, or the effect's id.
    pub id: &'static str,
    /// Its name for a reader.
    pub title: &'static str,
    /// Its numbers among the packed parameters.
    lanes: Vec<usize>,
    of: Of,
}

/// What a group is of.
#[derive(Clone, Copy)]
enum Of {
    /// The plant: its damping (0), stiffness (1) or gain (2).
    Plant(usize),
    /// The term of this number.
    Term(usize),
}

/// A recording, fitted.
struct Determined<'a> {
    data: Data<'a>,
    fitted: Fitted,
    /// What it says of the packed parameters, in units of its noise.
    information: Symmetric,
    /// −2 log likelihood, but for a constant.
    deviance: f64,
    /// For how many times as large errors are taken as the noise says.
    wider: f64,
}

/// See the module.
pub struct Joint<'a> {
    sides: [Determined<'a>; 2],
    /// What may differ.
    pub groups: Vec<Group>,
    /// Number of effects among which one of the groups was sought.
    sought: usize,
}

/// The parameters where some groups differ.
pub struct Solved {
    /// The packed parameters of each recording.
    packed: [Vec<f64>; 2],
    /// Covariance of the common parameters, then of the differences.
    covariance: Symmetric,
    /// The numbers of the parameters that differ.
    differing: Vec<usize>,
    /// What is left of the distance of the two fits, in units of the noise.
    left: f64,
}

/// A parameter in both recordings.
pub struct Both {
    /// In the earlier one.
    pub then: Parameter,
    /// In the later one.
    pub now: Parameter,
    /// Standard error of the difference.
    pub error: f64,
}

/// The model of one recording with the effects of both, in the same order for either.
fn with_effects_of_both(models: [&Model; 2], recording: usize) -> Model {
    let (own, other) = (models[recording], models[1 - recording]);
    let mut union = Model { terms: Vec::new(), ..own.clone() };
    for term in models.iter().flat_map(|model| &model.terms) {
        let of = |model: &Model| model.terms.iter().find(|t| t.effect.id == term.effect.id).cloned();
        if of(&union).is_some() {
            continue;
        }
        let mut known = of(own).unwrap_or_else(|| term.clone());
        if let Some(theirs) = of(other) {
            known.free.iter_mut().zip(&theirs.free).for_each(|(own, theirs)| *own |= theirs);
        }
        union.terms.push(known);
    }
    union
}

/// The model with the amounts at zero of the effects that `own` has not.
fn without_amounts(model: &Model, own: &Model) -> Model {
    let mut model = model.clone();
    for term in &mut model.terms {
        if own.terms.iter().all(|known| known.effect.id != term.effect.id) {
            let parameters = term.effect.parameters.iter().zip(&mut term.parameters);
            parameters.filter(|(p, _)| !p.shape).for_each(|(_, value)| *value = 0.0);
        }
    }
    model
}

impl<'a> Determined<'a> {
    fn of(recording: &'a DynamicRecording, starts: &[Model], wider: f64) -> Option<Determined<'a>> {
        let data = Data::new(recording);
        let fits = starts.iter().filter_map(|model| fit(model, &data.first_states(), &data, ALL));
        let fitted = fits.min_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)))?;
        let (information, deviance) = information(&fitted, &data, ALL, wider)?;
        Some(Determined { data, fitted, information, deviance, wider })
    }

    /// The same by the rows alone that do not score.
    fn unscored(&self) -> Option<Determined<'a>> {
        let fitted = fit(&self.fitted.model, &self.fitted.states, &self.data, UNSCORED)?;
        let (information, deviance) = information(&fitted, &self.data, UNSCORED, self.wider)?;
        Some(Determined { data: self.data.clone(), fitted, information, deviance, ..*self })
    }

    /// What packed parameters leave of every row; the initial states are fitted to `folds`.
    fn left(&self, packed: &[f64], folds: Folds) -> Option<Vec<f64>> {
        let mut model = self.fitted.model.unpacked(packed);
        model.nominal_free = [false; 3];
        model.terms.iter_mut().for_each(|term| term.free.fill(false));
        fit(&model, &self.fitted.states, &self.data, folds)?.residual(&self.data)
    }

    /// The stretches of rows that score.
    fn scored(&self) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        for run in &self.data.runs {
            for row in run.clone().filter(|row| usize::from(self.data.fold[*row]) == SCORE) {
                match stretches.last_mut().filter(|last| last.end == row && row > run.start) {
                    Some(last) => last.end = row + 1,
                    None => stretches.push(row..row + 1),
                }
            }
        }
        stretches
    }
}

/// What some rows say of the packed parameters, and −2 log likelihood; structure that is left makes errors `wider`.
fn information(fitted: &Fitted, data: &Data, folds: Folds, wider: f64) -> Option<(Symmetric, f64)> {
    let noise = autoregression(&residual(fitted, data), &data.runs);
    let whole = fitted.model.normal(&fitted.states, data, &noise.coefficients).ok()?;
    let mut information = whole.reduced(folds, 0.0, &[]).part(0..fitted.model.free());
    let rows = whole.rows(folds).max(1) as f64;
    let square = whole.cost(folds) / rows;
    let scale = wider * wider * square;
    information.entries.iter_mut().for_each(|entry| *entry /= scale);
    let deviance = rows * square.ln() / (wider * wider);
    let finite = deviance.is_finite() && information.entries.iter().all(|entry| entry.is_finite());
    finite.then_some((information, deviance))
}

impl<'a> Joint<'a> {
    /// Of two recordings, whose own models are `models`; errors are taken for so many times as large as their noise says. None
    /// where one of them cannot be fitted with the effects of both.
    pub fn new(recordings: [&'a DynamicRecording; 2], models: [&Model; 2], wider: [f64; 2]) -> Option<Self> {
        let of = |recording: usize| {
            let own = models[recording];
            let union = with_effects_of_both(models, recording);
            let starts = [union.clone(), without_amounts(&union, own)];
            let starts = if union.terms.len() > own.terms.len() { &starts[..] } else { &starts[..1] };
            Determined::of(recordings[recording], starts, wider[recording])
        };
        let (a, b) = parallel::join(|| of(0), || of(1));
        let sides = [a?, b?];
        let model = &sides[0].fitted.model;
        if models[0].nominal_free != models[1].nominal_free || model.free() != sides[1].fitted.model.free() {
            return None;
        }
        let plant = (0..3).filter(|k| model.nominal_free[*k]).enumerate();
        let plant = plant.map(|(lane, k)| {
            let [id, title, _] = PLANT[k];
            Group { id, title, lanes: vec![lane], of: Of::Plant(k) }
        });
        let effects = model.terms.iter().enumerate().map(|(k, term)| Group {
            id: term.effect.id,
            title: term.effect.title,
            lanes: model.packed_of(k).into_iter().flatten().collect(),
            of: Of::Term(k),
        });
        let groups = plant.chain(effects).filter(|group| !group.lanes.is_empty()).collect();
        Some(Joint { sides, groups, sought: 0 })
    }

    /// The same where one of its effects was sought among so many.
    pub fn sought_among(self, sought: usize) -> Joint<'a> {
        Joint { sought, ..self }
    }

    /// Number of things whose difference was, or would have been, looked at.
    pub fn looked_at(&self) -> usize {
        self.groups.len() + self.sought
    }

    /// Akaike's criterion of both recordings where some groups differ: −2 log likelihood, and two for each parameter that
    /// differs and for the choice among the effects that were sought.
    pub fn criterion(&self, changed: &[usize]) -> f64 {
        let solved = self.solve(changed);
        let own: f64 = self.sides.iter().map(|side| side.deviance).sum();
        own + solved.left + 2.0 * (solved.differing.len() as f64 + (self.sought.max(1) as f64).ln())
    }

    /// The same by the rows alone that do not score.
    pub fn unscored(&self) -> Option<Joint<'a>> {
        let (a, b) = parallel::join(|| self.sides[0].unscored(), || self.sides[1].unscored());
        let groups = self.groups.iter().map(|group| Group { lanes: group.lanes.clone(), ..*group });
        Some(Joint { sides: [a?, b?], groups: groups.collect(), sought: self.sought })
    }

    /// The parameters with these groups differing.
    pub fn solve(&self, changed: &[usize]) -> Solved {
        let [then, now] = self.sides.each_ref().map(|side| side.fitted.model.packed());
        let apart: Vec<f64> = now.iter().zip(&then).map(|(now, then)| now - then).collect();
        let differing: Vec<usize> = changed.iter().flat_map(|g| self.groups[*g].lanes.clone()).collect();
        let (n, all) = (then.len(), then.len() + differing.len());
        // Every unknown is a parameter: the common ones are in both recordings, the differences in the later one.
        let lane = |unknown: usize| if unknown < n { unknown } else { differing[unknown - n] };
        let [in_then, in_now] = self.sides.each_ref().map(|side| &side.information);
        let pull: Vec<f64> = (0..n).map(|i| (0..n).map(|j| in_now.at(i, j) * apart[j]).sum()).collect();
        let mut normal = Symmetric::zero(all);
        for i in 0..all {
            for j in 0..all {
                let common = if i < n && j < n { in_then.at(i, j) } else { 0.0 };
                *normal.at_mut(i, j) = common + in_now.at(lane(i), lane(j));
            }
        }
        let right: Vec<f64> = (0..all).map(|i| pull[lane(i)]).collect();
        let factor = normal.factor();
        let unknowns = factor.solve(&right);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let left = dot(&apart, &pull) - dot(&right, &unknowns);
        let common: Vec<f64> = then.iter().zip(&unknowns).map(|(then, by)| then + by).collect();
        let mut later = common.clone();
        differing.iter().zip(&unknowns[n..]).for_each(|(lane, by)| later[*lane] += by);
        Solved { packed: [common, later], covariance: factor.inverse(), differing, left }
    }

    /// −ln of the p-value that each group differs, beside others that do.
    pub fn surprises(&self, changed: &[usize]) -> Vec<f64> {
        let left = self.solve(changed).left;
        let of = |group: usize| {
            let explained = left - self.solve(&[changed, &[group]].concat()).left;
            log_tail(explained.max(0.0), self.groups[group].lanes.len())
        };
        (0..self.groups.len()).map(|group| if changed.contains(&group) { 0.0 } else { of(group) }).collect()
    }

    /// The p-value that a group's amounts are zero in a recording; 0 of the plant.
    pub fn absence(&self, solved: &Solved, group: usize, recording: usize) -> f64 {
        let Of::Term(k) = self.groups[group].of else { return 0.0 };
        let model = &self.sides[0].fitted.model;
        let parameters = model.terms[k].effect.parameters.iter().zip(model.packed_of(k));
        let amounts: Vec<usize> = parameters.filter(|(p, _)| !p.shape).filter_map(|(_, lane)| lane).collect();
        if amounts.is_empty() {
            return 0.0;
        }
        let mut covariance = Symmetric::zero(amounts.len());
        for (i, a) in amounts.iter().enumerate() {
            for (j, b) in amounts.iter().enumerate() {
                *covariance.at_mut(i, j) = solved.covariance([recording, recording], [*a, *b]);
            }
        }
        let value: Vec<f64> = amounts.iter().map(|lane| solved.packed[recording][*lane]).collect();
        let square: f64 = covariance.factor().solve(&value).iter().zip(&value).map(|(a, b)| a * b).sum();
        (-log_tail(square.max(0.0), amounts.len())).exp()
    }

    /// A group's parameters in both recordings, with 95 % intervals.
    pub fn parameters(&self, solved: &Solved, group: usize, plant: &Plant) -> Vec<Both> {
        let group = &self.groups[group];
        let models = [0, 1].map(|r| self.sides[r].fitted.model.unpacked(&solved.packed[r]));
        match group.of {
            Of::Plant(k) => {
                let [then, now] = models.map(|model| nominal(model.nominal, [0.0; 3], plant).swap_remove(k));
                let gradient = [(group.lanes[0], 1.0)];
                vec![solved.both([then, now], [&gradient, &gradient], Sort::Amount)]
            }
            Of::Term(k) => {
                let lanes = models[0].packed_of(k);
                let readings = models.each_ref().map(|model| readings(&model.terms[k], &lanes, plant));
                let [then, now] = readings;
                let pairs = then.into_iter().zip(now);
                pairs.map(|((a, x, sort), (b, y, _))| solved.both([a, b], [&x, &y], sort)).collect()
            }
        }
    }

    /// What a model of the later recording leaves of it.
    pub fn rms(&self, solved: &Solved) -> Option<f64> {
        let left = self.sides[1].left(&solved.packed[1], ALL)?;
        let rows = self.sides[1].data.runs.iter().flat_map(Clone::clone);
        Some(rms(&rows.map(|row| left[row]).collect::<Vec<f64>>()))
    }

    /// What two models leave of the stretches of both recordings that score, each a root mean square in the later one's unit;
    /// those of the earlier one count by the ratio of their noise.
    pub fn scores(&self, models: [&Solved; 2]) -> Option<Vec<[f64; 2]>> {
        let noise = self.sides.each_ref().map(|side| side.fitted.rms(UNSCORED));
        let mut scores = Vec::new();
        for (recording, side) in self.sides.iter().enumerate() {
            let left = [0, 1].map(|m| side.left(&models[m].packed[recording], UNSCORED));
            let [Some(a), Some(b)] = left else { return None };
            let scale = noise[1] / noise[recording];
            let of = |left: &[f64], rows: &Range<usize>| scale * rms(&left[rows.clone()]);
            scores.extend(side.scored().iter().map(|rows| [of(&a, rows), of(&b, rows)]));
        }
        Some(scores)
    }
}

/// By which packed parameters a reading changes, and how fast.
type Gradient = Vec<(usize, f64)>;

/// The reported parameters of a term, as yet without intervals.
fn readings(term: &Term, lanes: &[Option<usize>], plant: &Plant) -> Vec<(Parameter, Gradient, Sort)> {
    let one = |reading: &Reading| {
        let parameter = Parameter {
            name: reading.name.into(),
            value: reading.value,
            unit: unit_of(reading.unit, &plant.position_unit, &plant.drive_unit),
            ci95: [reading.value; 2],
        };
        let by = lanes.iter().zip(slopes(reading, term));
        (parameter, by.filter_map(|(lane, slope)| Some(((*lane)?, slope))).collect(), sort(term, reading))
    };
    term.effect.readings(&term.parameters).iter().map(one).collect()
}

impl Solved {
    /// Covariance of two parameters, each of one of the recordings.
    fn covariance(&self, recordings: [usize; 2], lanes: [usize; 2]) -> f64 {
        let unknowns = |k: usize| {
            let difference = self.differing.iter().position(|lane| *lane == lanes[k]);
            let difference = difference.filter(|_| recordings[k] == 1).map(|d| self.packed[0].len() + d);
            std::iter::once(lanes[k]).chain(difference)
        };
        unknowns(0).flat_map(|i| unknowns(1).map(move |j| self.covariance.at(i, j))).sum()
    }

    /// A parameter in both recordings, with what each is by the packed parameters.
    fn both(&self, [then, now]: [Parameter; 2], gradients: [&[(usize, f64)]; 2], sort: Sort) -> Both {
        let covariance = |a: usize, b: usize| -> f64 {
            let pairs = gradients[a].iter().flat_map(|x| gradients[b].iter().map(move |y| (x, y)));
            pairs.map(|((i, x), (j, y))| x * y * self.covariance([a, b], [*i, *j])).sum()
        };
        let estimated = |parameter: Parameter, r: usize| {
            let deviation = covariance(r, r).max(0.0).sqrt();
            Parameter { ci95: around(parameter.value, deviation, sort), ..parameter }
        };
        let square = covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1);
        Both { then: estimated(then, 0), now: estimated(now, 1), error: square.max(0.0).sqrt() }
    }
}
