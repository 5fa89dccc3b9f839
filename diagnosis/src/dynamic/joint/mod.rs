//! One model of two recordings of a mechanism: every parameter is the same in both, or differs.
//!
//! Each recording is fitted by a model with the effects of both. A model of both is then estimated by Marquardt's method from
//! what each recording says of it; whether something else differs is judged to first order about that.

mod coefficients;
pub mod equations;
mod expansion;
pub mod feedback;
pub mod free_run;
pub mod modes;
mod second_order;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use numerics::{Symmetric, parallel, rms};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use self::expansion::{Direction, Evaluation, Expansion, Point, estimated, promised, together};
use super::data::{ALL, Data, Folds, SCORE};
use super::interval::{Sort, around};
use super::model::Term;
use crate::calibrate::log_tail;
use crate::thresholds::compare::{FALSE_ALARMS, PRESENT};
use crate::verdict::{Location, Parameter};

/// What may differ: a parameter of the plant, or an effect.
#[derive(Clone)]
pub struct Group {
    /// The name of the plant's parameter, or the effect's id.
    pub id: String,
    /// Its name for a reader.
    pub title: String,
    /// How the packed parameters may differ.
    pub directions: Vec<Direction>,
    /// What it is of.
    pub of: Of,
}

impl Group {
    /// Of packed parameters that differ each by itself.
    fn of_lanes(id: &str, title: &str, lanes: impl IntoIterator<Item = usize>, of: Of) -> Group {
        let directions = lanes.into_iter().map(|lane| vec![(lane, 1.0)]).collect();
        Group { id: id.into(), title: title.into(), directions, of }
    }

    /// Of terms of which the first amount alone differs: the simpler effects that this amount is, but for those that the model
    /// has beside. `first` is the packed parameter of a term's first amount; none where it is fixed.
    fn of_special_cases(terms: &[Term], first: impl Fn(usize) -> Option<usize>) -> Vec<Group> {
        let of = |(k, term): (usize, &Term)| {
            let simpler = term.effect.special_case?;
            if terms.iter().any(|term| term.effect.id == simpler.id) {
                return None;
            }
            Some(Group::of_lanes(simpler.id, simpler.title, [first(k)?], Of::Term(k)))
        };
        terms.iter().enumerate().filter_map(of).collect()
    }

    /// Of an effect: all that is free of it differs, or its amounts alone, as where it came with a shape.
    fn of_effect(id: &str, title: &str, free: Vec<usize>, amounts: Vec<usize>, of: Of) -> Vec<Group> {
        let both = !amounts.is_empty() && amounts.len() < free.len();
        let alone = both.then(|| Group::of_lanes(id, title, amounts, of));
        std::iter::once(Group::of_lanes(id, title, free, of)).chain(alone).collect()
    }

    /// Of terms of which several amounts differ by one factor: an effect that became stronger. `amounts` are the packed
    /// parameters of a term's amounts.
    fn of_strengths(terms: &[Term], packed: &[f64], amounts: impl Fn(usize) -> Vec<usize>) -> Vec<Group> {
        let of = |(k, term): (usize, &Term)| {
            let grows: Direction = amounts(k).into_iter().map(|lane| (lane, packed[lane])).collect();
            let several = grows.len() > 1 && grows.iter().all(|(_, amount)| *amount != 0.0);
            several.then(|| Group {
                id: term.effect.id.into(),
                title: term.effect.title.into(),
                directions: vec![grows],
                of: Of::Term(k),
            })
        };
        terms.iter().enumerate().filter_map(of).collect()
    }

    /// Of a mechanism whose parameters are per inertia: these all fall as it grows. None where that is one parameter.
    fn of_inertia(packed: &[f64], per_inertia: impl IntoIterator<Item = usize>) -> Option<Group> {
        let falls: Direction = per_inertia.into_iter().map(|lane| (lane, -packed[lane])).collect();
        (falls.len() > 1).then(|| Group {
            id: INERTIA.into(),
            title: INERTIA_TITLE.into(),
            directions: vec![falls],
            of: Of::Inertia,
        })
    }
}

/// Id of the inertia.
pub const INERTIA: &str = "inertia";
/// Its name for a reader.
pub const INERTIA_TITLE: &str = "the inertia of the mechanism";

/// What a group is of.
#[derive(Clone, Copy)]
pub enum Of {
    /// The plant's parameter of this number.
    Plant(usize),
    /// The term of this number.
    Term(usize),
    /// What all that is per inertia has in common.
    Inertia,
    /// The part of this number of a structure of many modes.
    Structure(usize),
}

/// By which packed parameters a reading changes, and how fast.
pub type Gradient = Vec<(usize, f64)>;

/// A reported parameter, as yet without its interval.
pub type Reported = (Parameter, Gradient, Sort);

/// One of the recordings, fitted by a model with the effects of both.
pub trait Side: Sized + Send + Sync {
    /// What may differ, in the same order for both recordings.
    fn groups(&self) -> Vec<Group>;

    /// The packed parameters.
    fn packed(&self) -> Vec<f64>;

    /// The model at some packed parameters; none where it cannot be simulated there.
    fn evaluate(&self, packed: &[f64]) -> Option<Evaluation<'_>>;

    /// What it says about its own fit.
    fn own(&self) -> &Expansion;

    /// What it says to first order about its own fit.
    fn by_own_fit(&self, packed: &[f64]) -> Expansion {
        let by: Vec<f64> = packed.iter().zip(self.packed()).map(|(to, from)| to - from).collect();
        self.own().shifted(&by)
    }

    /// −2 log likelihood, but for a constant.
    fn deviance(&self) -> f64;

    /// Degrees of freedom of the noise; none where it is known as well as a normal one.
    fn freedom(&self) -> Option<f64> {
        None
    }

    /// The kinds of rows that are held out, one after the other.
    fn held_out(&self) -> &'static [usize] {
        &[SCORE]
    }

    /// The same by the rows alone that are not of a kind.
    fn without(&self, kind: usize) -> Option<Self>;

    /// What packed parameters leave of every row; what belongs to this recording alone is fitted to `folds`.
    fn left(&self, packed: &[f64], folds: Folds) -> Option<Vec<f64>>;

    /// Root mean square of what its own fit leaves of the rows to which it was fitted.
    fn noise(&self) -> f64;

    /// Runs and kinds of rows.
    fn data(&self) -> &Data<'_>;

    /// The stretches of rows of a kind.
    fn stretches(&self, kind: usize) -> Vec<Range<usize>> {
        stretches(self.data(), kind)
    }

    /// The reported parameters of a group at packed parameters, as yet without intervals.
    fn readings(&self, of: Of, packed: &[f64]) -> Vec<Reported>;

    /// The packed parameters that multiply a term; none of the plant.
    fn amounts(&self, of: Of) -> Vec<usize>;

    /// What multiplies a group in the later recording, with its standard error, where the group differs by a length of its only
    /// direction with an error, from packed parameters `then`; none of a group with parameters of its own.
    fn ratio(&self, of: Of, _then: &[f64], length: f64, error: f64) -> Option<(f64, f64)> {
        matches!(of, Of::Inertia).then(|| (1.0 / (1.0 - length), error / (1.0 - length).powi(2)))
    }

    /// From how many shapes an effect is sought in a recording by itself.
    fn sought(&self, _of: Of) -> usize {
        1
    }

    /// Whether an effect can have these packed parameters: friction is not negative.
    fn is_plausible(&self, _of: Of, _packed: &[f64]) -> bool {
        true
    }

    /// Part of the square of what is left of held-out rows that a difference must explain.
    fn least_part(&self) -> f64 {
        0.0
    }

    /// Whether a row counts in what a model leaves.
    fn counts(&self, _row: usize) -> bool {
        true
    }

    /// Where a change of a group lives in the recording.
    fn place(&self, group: &Group, p_value: f64) -> Option<Location>;
}

/// See the module.
pub struct Joint<S> {
    sides: [S; 2],
    /// What may differ.
    pub groups: Vec<Group>,
    /// Number of effects among which one of the groups was sought.
    sought: usize,
    /// That effect, where one was found.
    pub found: Option<Sought>,
    /// Solutions by the groups that differ: choice, proof and report ask for the same ones.
    solved: Mutex<HashMap<Vec<usize>, Arc<Solved>>>,
}

/// An effect that was sought for a recording because of the other one.
pub struct Sought {
    /// The recording.
    pub recording: usize,
    /// Its id.
    pub id: String,
    /// Those of others that do nearly as well in its place.
    pub rivals: Vec<String>,
}

/// The parameters where some groups differ.
pub struct Solved {
    /// The packed parameters of each recording.
    point: Point,
    /// Covariance of the common parameters, then of the lengths of the differences.
    covariance: Symmetric,
    /// How the parameters differ.
    differing: Vec<Direction>,
    /// What is left of both recordings, in units of their noise, beyond what their own fits leave.
    left: f64,
    /// What each recording says about there.
    about: [Expansion; 2],
    /// Whether both could be simulated there; else that is what their own fits say to first order.
    simulated: bool,
}

/// A parameter in both recordings.
pub struct Both {
    /// In the earlier one.
    pub then: Parameter,
    /// In the later one.
    pub now: Parameter,
    /// Standard error of the difference.
    pub error: f64,
    /// Whether it grows with the effect's amounts. A shape or a phase does not, and says nothing where the effect is not there.
    pub grows: bool,
}

/// The stretches of rows of a kind.
fn stretches(data: &Data, kind: usize) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for run in &data.runs {
        for row in run.clone().filter(|row| usize::from(data.fold[*row]) == kind) {
            match stretches.last_mut().filter(|last| last.end == row && row > run.start) {
                Some(last) => last.end = row + 1,
                None => stretches.push(row..row + 1),
            }
        }
    }
    stretches
}

/// The p-value of the most surprising of so many tests (Bonferroni).
fn family_wise(surprise: f64, tests: usize) -> f64 {
    (tests as f64 * (-surprise).exp()).min(1.0)
}

impl<S: Side> Joint<S> {
    /// Of two recordings that were fitted by the same model.
    pub fn new(then: S, now: S) -> Joint<S> {
        let groups = then.groups().into_iter().filter(|group| !group.directions.is_empty()).collect();
        Joint { sides: [then, now], groups, sought: 0, found: None, solved: Mutex::default() }
    }

    /// The same where one of its effects was sought among so many.
    pub fn sought_among(self, sought: usize) -> Joint<S> {
        Joint { sought, ..self }
    }

    /// Number of things whose difference was, or would have been, looked at.
    pub fn looked_at(&self) -> usize {
        self.groups.len() + self.sought
    }

    /// Number of parameters that both recordings have.
    pub fn in_common(&self) -> usize {
        self.sides[0].packed().len()
    }

    /// Akaike's criterion of both recordings where some groups differ: −2 log likelihood, and two for each parameter that
    /// differs and for the choice among the effects that were sought.
    pub fn criterion(&self, changed: &[usize]) -> f64 {
        let solved = self.solve(changed);
        let own: f64 = self.sides.iter().map(S::deviance).sum();
        own + solved.left + 2.0 * (solved.differing.len() as f64 + (self.sought.max(1) as f64).ln())
    }

    /// The same by the rows alone that are not of a kind, of each kind that is held out.
    pub fn without_each(&self) -> Vec<(usize, Joint<S>)> {
        let without = |kind: usize| {
            let (a, b) = parallel::join(|| self.sides[0].without(kind), || self.sides[1].without(kind));
            let (sides, groups) = ([a?, b?], self.groups.clone());
            let joint = Joint { sides, groups, sought: self.sought, found: None, solved: Mutex::default() };
            Some((kind, joint))
        };
        self.sides[0].held_out().iter().filter_map(|kind| without(*kind)).collect()
    }

    /// The parameters with these groups differing.
    pub fn solve(&self, changed: &[usize]) -> Arc<Solved> {
        let known = || self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(solved) = known().get(changed) {
            return solved.clone();
        }
        let solved = Arc::new(self.compute(changed));
        known().insert(changed.to_vec(), solved.clone());
        solved
    }

    fn compute(&self, changed: &[usize]) -> Solved {
        let differing = self.directions(changed);
        let own = self.sides.each_ref().map(S::packed);
        let of_own = |recording: usize, packed: &[f64]| Some(self.sides[recording].by_own_fit(packed).into());
        // With every difference of one parameter as the own fits have it.
        let apart = |direction: &Direction| match direction[..] {
            [(lane, part)] => (own[1][lane] - own[0][lane]) / part,
            _ => 0.0,
        };
        let start = |recording: usize| {
            let packed = [own[recording].clone(), own[recording].clone()];
            let mut point = Point { packed, lengths: differing.iter().map(apart).collect() };
            for (direction, length) in differing.iter().zip(&point.lengths) {
                let sign = [1.0, -1.0][recording];
                let other = &mut point.packed[1 - recording];
                direction.iter().for_each(|(lane, part)| other[*lane] += sign * length * part);
            }
            point
        };
        let fewer = changed.split_last().map(|(_, fewer)| self.solve(fewer));
        let mut starts = [0, 1].map(start).to_vec();
        // Where the last one does not differ: from there an estimate never explains less than without it.
        starts.extend(fewer.as_ref().map(|fewer| {
            let mut point = fewer.point.clone();
            point.lengths.resize(differing.len(), 0.0);
            point
        }));
        let first = estimated(&starts, &differing, of_own);
        starts.extend(first.iter().map(|(point, _)| point.clone()));
        let exact = |recording: usize, packed: &[f64]| {
            let side = &self.sides[recording];
            let before = fewer.as_ref().filter(|fewer| fewer.simulated);
            let before = before.map(|fewer| (&fewer.point.packed[recording], &fewer.about[recording]));
            let mut known = std::iter::once((&own[recording], side.own())).chain(before);
            let there = known.find(|(at, _)| *at == packed);
            there.map(|(_, expansion)| expansion.clone().into()).or_else(|| side.evaluate(packed))
        };
        let found = estimated(&starts, &differing, exact);
        let simulated = found.is_some();
        let (point, about) =
            found.or(first).unwrap_or_else(|| unreachable!("the own fits say something everywhere"));
        let left = about.iter().zip(&self.sides).map(|(about, side)| about.cost - side.own().cost).sum();
        let covariance = together(&about, &differing).0.factor().inverse();
        Solved { point, covariance, differing, left, about, simulated }
    }

    fn directions(&self, groups: &[usize]) -> Vec<Direction> {
        groups.iter().flat_map(|group| self.groups[*group].directions.clone()).collect()
    }

    /// The same to first order where one more group differs.
    pub fn extended(&self, solved: &Solved, group: usize) -> Solved {
        let differing = [&solved.differing[..], &self.groups[group].directions].concat();
        let covariance = together(&solved.about, &differing).0.factor().inverse();
        let (mut point, about) = (solved.point.clone(), solved.about.clone());
        point.lengths.resize(differing.len(), 0.0);
        Solved { point, covariance, differing, left: solved.left, about, simulated: solved.simulated }
    }

    /// −ln of the p-value that each group differs, beside others that do: by the estimated parameters, but where the first
    /// order holds and is within chance.
    pub fn surprises(&self, changed: &[usize]) -> Vec<f64> {
        let solved = self.solve(changed);
        let without = promised(&solved.about, &solved.differing);
        let explained = |k: usize| solved.left - self.solve(&[changed, &[k]].concat()).left;
        let of = |k: usize| {
            let group = &self.groups[k];
            let surprise = |squares: f64| self.surprise(squares.max(0.0), group.directions.len());
            if changed.contains(&k) {
                return 0.0;
            }
            let directions = [&solved.differing[..], &group.directions].concat();
            let first_order = || surprise(promised(&solved.about, &directions) - without);
            let within_chance = |surprise: &f64| self.family_wise(*surprise) > FALSE_ALARMS;
            let promised = self.is_linear(k).then(first_order).filter(within_chance);
            promised.unwrap_or_else(|| surprise(explained(k)))
        };
        parallel::indices(0..self.groups.len(), of)
    }

    /// The family-wise p-value of a group with this −ln p, over all that were looked at.
    pub fn family_wise(&self, surprise: f64) -> f64 {
        family_wise(surprise, self.looked_at())
    }

    /// Whether the first order says what a group explains by its difference. It does not where an effect has shapes: where one
    /// recording alone has it, its shape in a model of both is a compromise, about which the cost may hardly fall.
    fn is_linear(&self, group: usize) -> bool {
        let of = self.groups[group].of;
        let Of::Term(term) = of else { return true };
        let of_term = |group: &&Group| matches!(group.of, Of::Term(other) if other == term);
        let amounts = self.sides[0].amounts(of);
        self.groups.iter().filter(of_term).all(|group| within(&group.directions, &amounts))
    }

    /// Whether costs fall at once where a group begins to differ. A limit that is beyond the drive changes nothing at first.
    fn has_slope(&self, group: usize) -> bool {
        let of = self.groups[group].of;
        !matches!(of, Of::Term(_)) || !self.sides[0].amounts(of).is_empty()
    }

    /// The two groups that differ most surprisingly together, and their family-wise p-value over all pairs, also with what was
    /// sought.
    pub fn pair(&self) -> Option<([usize; 2], f64)> {
        let solved = self.solve(&[]);
        let without = promised(&solved.about, &[]);
        let count = self.groups.len();
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let of = |pair: [usize; 2]| {
            let directions = self.directions(&pair);
            let explained = (promised(&solved.about, &directions) - without).max(0.0);
            (pair, self.surprise(explained, directions.len()))
        };
        let best = pairs.map(of).max_by(|a, b| a.1.total_cmp(&b.1));
        let looked_at = self.looked_at();
        best.map(|(pair, surprise)| (pair, family_wise(surprise, looked_at * (looked_at - 1) / 2)))
    }

    /// −ln of the p-value that so many parameters explain so much by chance, in units of the noise.
    fn surprise(&self, explained: f64, rank: usize) -> f64 {
        let tail = |freedom: f64| {
            let f = FisherSnedecor::new(rank as f64, freedom).ok()?;
            Some(-f.sf(explained / rank as f64).max(f64::MIN_POSITIVE).ln())
        };
        let freedoms: Option<Vec<f64>> = self.sides.iter().map(S::freedom).collect();
        freedoms.and_then(|both| tail(both.iter().sum())).unwrap_or_else(|| log_tail(explained, rank))
    }

    /// The p-value that a group's amounts are zero in a recording; 0 of the plant, 1 of an effect without amounts. Where shapes
    /// differ, over all from which they are sought: noise has a best one, too.
    pub fn absence(&self, solved: &Solved, group: usize, recording: usize) -> f64 {
        let Group { of, ref directions, .. } = self.groups[group];
        let amounts = self.sides[0].amounts(of);
        if amounts.is_empty() {
            return if matches!(of, Of::Term(_)) { 1.0 } else { 0.0 };
        }
        let mut covariance = Symmetric::zero(amounts.len());
        for (i, a) in amounts.iter().enumerate() {
            for (j, b) in amounts.iter().enumerate() {
                *covariance.at_mut(i, j) = solved.covariance([recording, recording], [*a, *b]);
            }
        }
        let value: Vec<f64> = amounts.iter().map(|lane| solved.point.packed[recording][*lane]).collect();
        let square: f64 = covariance.factor().solve(&value).iter().zip(&value).map(|(a, b)| a * b).sum();
        let p_value = (-self.surprise(square.max(0.0), amounts.len())).exp();
        let sought = if within(directions, &amounts) { 1 } else { self.sides[recording].sought(of) };
        (sought as f64 * p_value).min(1.0)
    }

    /// Whether a group's effect is there in a recording: friction that is negative is none. One without amounts is where it was
    /// found.
    pub fn shows(&self, solved: &Solved, group: usize, recording: usize) -> bool {
        if !self.has_slope(group) {
            let id = &self.groups[group].id;
            return self.found.as_ref().is_some_and(|found| found.id == *id && found.recording == recording);
        }
        let packed = &solved.point.packed[recording];
        self.absence(solved, group, recording) < PRESENT
            && self.sides[recording].is_plausible(self.groups[group].of, packed)
    }

    /// Whether the effect of a group has possible parameters in every recording that shows it, where some groups differ.
    pub fn is_plausible(&self, group: usize, changed: &[usize]) -> bool {
        let solved = self.solve(changed);
        (0..2).all(|recording| {
            self.sides[recording].is_plausible(self.groups[group].of, &solved.point.packed[recording])
                || self.absence(&solved, group, recording) > PRESENT
        })
    }

    /// Part of the square of what is left of held-out rows that a difference must explain.
    pub fn least_part(&self) -> f64 {
        self.sides[1].least_part()
    }

    /// A group's parameters in both recordings, with 95 % intervals.
    pub fn parameters(&self, solved: &Solved, group: usize) -> Vec<Both> {
        let of = self.groups[group].of;
        let [then, now] = [0, 1].map(|r| self.sides[r].readings(of, &solved.point.packed[r]));
        let amounts = self.sides[0].amounts(of);
        then.into_iter().zip(now).map(|(then, now)| solved.both(then, now, &amounts)).collect()
    }

    /// What multiplies a group in the later recording, with its standard error; none of a group with parameters of its own.
    pub fn ratio(&self, solved: &Solved, group: usize) -> Option<(f64, f64)> {
        let Group { directions, of, .. } = &self.groups[group];
        let (length, error) = solved.length(directions.first()?)?;
        self.sides[0].ratio(*of, &solved.point.packed[0], length, error)
    }

    /// Where a change of a group lives in the later recording.
    pub fn place(&self, group: usize, p_value: f64) -> Option<Location> {
        self.sides[1].place(&self.groups[group], p_value)
    }

    /// What a model of the later recording leaves of it.
    pub fn rms(&self, solved: &Solved) -> Option<f64> {
        let side = &self.sides[1];
        let left = side.left(&solved.point.packed[1], ALL)?;
        let rows = side.data().runs.iter().flat_map(Clone::clone).filter(|row| side.counts(*row));
        Some(rms(&rows.map(|row| left[row]).collect::<Vec<f64>>()))
    }

    /// What two models leave of the stretches of both recordings that are of a kind, each a root mean square in the later one's
    /// unit; those of the earlier one count by the ratio of their noise.
    pub fn scores(&self, kind: usize, models: [&Solved; 2]) -> Option<Vec<[f64; 2]>> {
        let others = std::array::from_fn(|other| other != kind);
        let noise = self.sides.each_ref().map(S::noise);
        let mut scores = Vec::new();
        for (recording, side) in self.sides.iter().enumerate() {
            let left = [0, 1].map(|m| side.left(&models[m].point.packed[recording], others));
            let [Some(a), Some(b)] = left else { return None };
            let scale = noise[1] / noise[recording];
            let of = |left: &[f64], rows: &[usize]| {
                scale * rms(&rows.iter().map(|row| left[*row]).collect::<Vec<f64>>())
            };
            let stretches = side.stretches(kind).into_iter();
            let rows = stretches.map(|rows| rows.filter(|row| side.counts(*row)).collect::<Vec<usize>>());
            scores.extend(rows.filter(|rows| !rows.is_empty()).map(|rows| [of(&a, &rows), of(&b, &rows)]));
        }
        Some(scores)
    }
}

/// Whether some directions change these packed parameters alone.
fn within(directions: &[Direction], lanes: &[usize]) -> bool {
    directions.iter().flatten().all(|(lane, _)| lanes.contains(lane))
}

impl Solved {
    /// Covariance of two parameters, each of one of the recordings.
    fn covariance(&self, recordings: [usize; 2], lanes: [usize; 2]) -> f64 {
        let unknowns = |k: usize| -> Direction {
            let n = self.point.packed[0].len();
            let part = |direction: &Direction| {
                direction.iter().filter(|(lane, _)| *lane == lanes[k]).map(|(_, part)| part).sum::<f64>()
            };
            let differences = self.differing.iter().enumerate().filter(|_| recordings[k] == 1);
            let differences = differences.map(|(d, direction)| (n + d, part(direction)));
            std::iter::once((lanes[k], 1.0)).chain(differences).collect()
        };
        let [a, b] = [unknowns(0), unknowns(1)];
        let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
        pairs.map(|((i, a), (j, b))| a * b * self.covariance.at(*i, *j)).sum()
    }

    /// How far a direction goes, with its standard error; none where nothing differs so.
    fn length(&self, of: &Direction) -> Option<(f64, f64)> {
        let k = self.differing.iter().position(|direction| direction == of)?;
        let unknown = self.point.packed[0].len() + k;
        Some((self.point.lengths[k], self.covariance.at(unknown, unknown).max(0.0).sqrt()))
    }

    /// A parameter in both recordings; `amounts` are the packed parameters that multiply its effect.
    fn both(&self, (then, by_then, sort): Reported, (now, by_now, _): Reported, amounts: &[usize]) -> Both {
        let gradients = [by_then, by_now];
        let grows = |value: f64, recording: usize| {
            let by_amounts = gradients[recording].iter().filter(|(lane, _)| amounts.contains(lane));
            let packed = &self.point.packed[recording];
            let growth: f64 = by_amounts.map(|(lane, slope)| slope * packed[*lane]).sum();
            // But for rounding.
            growth.abs() > f64::EPSILON.sqrt() * value.abs()
        };
        let grows = grows(then.value, 0) || grows(now.value, 1);
        let covariance = |a: usize, b: usize| -> f64 {
            let pairs = gradients[a].iter().flat_map(|x| gradients[b].iter().map(move |y| (x, y)));
            pairs.map(|((i, x), (j, y))| x * y * self.covariance([a, b], [*i, *j])).sum()
        };
        let estimated = |parameter: Parameter, r: usize| {
            let deviation = covariance(r, r).max(0.0).sqrt();
            Parameter { ci95: around(parameter.value, deviation, sort), ..parameter }
        };
        let square = covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1);
        Both { then: estimated(then, 0), now: estimated(now, 1), error: square.max(0.0).sqrt(), grows }
    }
}

#[cfg(test)]
mod tests {
    use super::Group;
    use crate::dynamic::effects::effect;
    use crate::dynamic::model::Term;

    fn term(id: &str) -> Term {
        let effect = effect(id).unwrap();
        Term::new(effect, vec![0.0; effect.parameters.len()])
    }

    #[test]
    fn more_dry_friction_is_a_change_of_its_own_where_stribecks_law_holds_it() {
        let stribeck = [term("cogging"), term("stribeck_friction")];
        let groups = Group::of_special_cases(&stribeck, |k| Some(10 * k));
        let [group] = &groups[..] else { panic!("{}", groups.len()) };
        assert_eq!((group.id.as_str(), &group.directions[..]), ("coulomb_friction", &[vec![(10, 1.0)]][..]));
        assert!(Group::of_special_cases(&stribeck, |_| None).is_empty(), "the amount is fixed");
        let both = [term("coulomb_friction"), term("stribeck_friction")];
        assert!(Group::of_special_cases(&both, Some).is_empty(), "the model has it already");
    }

    #[test]
    fn an_effect_of_several_amounts_may_grow_as_a_whole() {
        let terms = [term("coulomb_friction"), term("stribeck_friction")];
        let amounts = |k: usize| [vec![0], vec![1, 2]][k].clone();
        let groups = Group::of_strengths(&terms, &[3.0, 4.0, 5.0], amounts);
        let [group] = &groups[..] else { panic!("{}", groups.len()) };
        let grows = vec![(1, 4.0), (2, 5.0)];
        assert_eq!((group.id.as_str(), &group.directions[..]), ("stribeck_friction", &[grows][..]));
        assert!(Group::of_strengths(&terms, &[3.0, 4.0, 0.0], amounts).is_empty(), "it is not there");
    }
}
