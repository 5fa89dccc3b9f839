//! Where the estimate of a plant in equations starts: points spread over the ranges of its parameters. An observer keeps
//! the simulation beside the recording while they are far off, and is made weaker until the simulation runs free: so an
//! oscillation never runs out of step, and a level never so far away that an estimate stops in a local minimum.

use fitter::plant::Hold;
use motion::equations::{EquationsError, Plant};
use physics::Parameter;
use rayon::prelude::*;
use std::sync::Arc;

use super::super::data::{ALL, Data, Folds, HOLDS};
use super::super::estimate::{Fitted, Simulated, fit, fit_in};
use super::model::{Model, is_logarithmic};
use crate::thresholds::dynamic::equations::{
    ACCURATE, APART, AS_WELL, BESIDE, FIRST_ROWS, FOLLOWED, LEAST_FIRST, MOST_SUBSTEPS, OBSERVED, POINTS,
    STEPS, WEAKER,
};
use crate::thresholds::dynamic::estimate::PATIENCE;

/// A plant without further effects, fitted to all rows.
pub struct Nominal {
    /// In the best way of running between the samples.
    pub free: Fitted<Model>,
    /// Under an observer, from the starts that did best: several where the recording leaves a parameter open, as an effect
    /// may not that is found later. The unit of a hidden state is such a one.
    pub observed: Vec<Fitted<Model>>,
}

/// Fits a plant; none where no start leads to one that can be simulated.
///
/// # Errors
/// [`EquationsError`].
pub fn nominal(plant: &Arc<Plant>, data: &Data) -> Result<Option<Nominal>, EquationsError> {
    let holds: Vec<Hold> = match plant.sampling {
        Some(hold) => vec![hold],
        None if plant.inputs.is_empty() => vec![Hold::ZeroOrder],
        None => HOLDS.to_vec(),
    };
    let plain = Model::new(plant.clone(), middle(plant), holds[0])?;
    let windowed = data.starts_s.iter().any(|start| *start > 0.0);
    let free_starts = plain.free_starts.iter().map(|free| *free || windowed).collect();
    let observed = observed(&Model { free_starts, observed: OBSERVED, ..plain }, data);
    let relaxed = observed.par_iter().filter_map(|f| relaxed(PATIENCE, &f.model, &f.states, data, ALL));
    let Some(best) = least(relaxed.collect()) else { return Ok(None) };
    let others = holds[1..]
        .par_iter()
        .filter_map(|hold| fit(&Model { hold: *hold, ..best.model.clone() }, &best.states, data, ALL));
    let others: Vec<Fitted<Model>> = others.collect();
    let free = least([vec![best], others].concat());
    Ok(free.map(|free| Nominal { observed: distinct(observed, free.model.hold), free }))
}

/// The one that leaves least.
fn least(all: Vec<Fitted<Model>>) -> Option<Fitted<Model>> {
    all.into_iter().min_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)))
}

/// Those that do as well as the first, with other parameters than those before them.
fn distinct(all: Vec<Fitted<Model>>, hold: Hold) -> Vec<Fitted<Model>> {
    let mut kept: Vec<Fitted<Model>> = Vec::new();
    for f in all {
        let (now, cost) = (f.model.packed(), f.cost(ALL));
        let apart = |g: &Fitted<Model>| {
            let pairs = g.model.packed().into_iter().zip(&now);
            pairs.map(|(a, b)| (a - b).abs() / a.abs().max(1.0)).fold(0.0, f64::max) > APART
        };
        if kept.first().is_none_or(|best| cost <= AS_WELL * best.cost(ALL)) && kept.iter().all(apart) {
            kept.push(Fitted { model: Model { hold, ..f.model.clone() }, ..f });
        }
    }
    kept
}

/// An estimate under a model's observer, then under ever weaker ones, and in free run in the end.
pub fn relaxed(
    patience: usize,
    model: &Model,
    states: &[Vec<f64>],
    data: &Data,
    folds: Folds,
) -> Option<Fitted<Model>> {
    let rows = data.runs.iter().map(|run| run.len()).max().unwrap_or(0) as f64;
    let mut fitted = estimated(patience, model, states, data, folds)?;
    while fitted.model.observed > 0.0 {
        let weaker = fitted.model.observed / WEAKER;
        // An observer that takes longer than the run hardly corrects anything.
        fitted.model.observed = if weaker * rows < 1.0 { 0.0 } else { weaker };
        fitted = estimated(patience, &fitted.model, &fitted.states, data, folds)?;
    }
    Some(fitted)
}

/// Every parameter in the middle of its range, or where the file puts it.
fn middle(plant: &Plant) -> Vec<f64> {
    let one =
        |(parameter, value): (&Parameter, &Option<f64>)| value.unwrap_or_else(|| within(parameter, 0.5));
    plant.parameters.iter().zip(&plant.values).map(one).collect()
}

/// The value at a part of a parameter's range, by its logarithm where that spans decades.
pub fn within(parameter: &Parameter, part: f64) -> f64 {
    match parameter.range {
        None => 0.0,
        Some(range) if is_logarithmic(parameter) => range.from * (range.to / range.from).powf(part),
        Some(range) => range.from + part * (range.to - range.from),
    }
}

/// Point `number` of Halton's sequence in so many dimensions (J. H. Halton, Numer. Math. 2, 1960).
fn spread(number: usize, dimensions: usize) -> Vec<f64> {
    let primes = (2..).filter(|n| (2..*n).all(|d| n % d != 0));
    let radical = |base: usize| {
        let (mut left, mut part, mut sum) = (number + 1, 1.0, 0.0);
        while left > 0 {
            part /= base as f64;
            sum += part * (left % base) as f64;
            left /= base;
        }
        sum
    };
    primes.take(dimensions).map(radical).collect()
}

/// The states at the start of every run, as far as the recorded position says.
fn first_states(model: &Model, data: &Data) -> Vec<Vec<f64>> {
    let plant = &model.plant;
    let output = plant.states.iter().position(|(name, _)| *name == plant.output.1.text);
    // The state that is the rate of the output.
    let rate = output.and_then(|k| {
        let text = &plant.rates[k].0.text;
        plant.states.iter().position(|(name, _)| name == text)
    });
    let guess = |[position, speed]: [f64; 2]| {
        let one = |k: usize| match plant.starts[k].filter(|_| !model.free_starts[k]) {
            Some(given) => given,
            None if Some(k) == rate => speed,
            None if Some(k) == output || plant.states[k].1 == *plant.output_unit() => position,
            None => plant.starts[k].unwrap_or(0.0),
        };
        (0..plant.states.len()).map(one).collect()
    };
    data.first_states().into_iter().map(guess).collect()
}

/// The best estimates under an observer over all starts: tried on the first rows, followed on all.
fn observed(plain: &Model, data: &Data) -> Vec<Fitted<Model>> {
    let head = data.clone().head((FIRST_ROWS / data.runs.len()).max(LEAST_FIRST));
    let free: Vec<usize> = (0..plain.values.len())
        .filter(|k| plain.plant.is_free(*k) && plain.plant.values[*k].is_none())
        .collect();
    let point = |number: usize| {
        let mut model = plain.clone();
        for (k, part) in free.iter().zip(spread(number, free.len())) {
            model.values[*k] = within(&plain.plant.parameters[*k], part);
        }
        model
    };
    let count = if free.is_empty() { 1 } else { POINTS };
    let states = first_states(plain, data);
    let tried = (0..count).into_par_iter().filter_map(|number| {
        let model = accurate(&point(number), &states, &head)?;
        fit_in(STEPS, &model, &states, &head, ALL)
    });
    let best = |mut all: Vec<Fitted<Model>>| {
        all.sort_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)));
        all.truncate(FOLLOWED);
        all
    };
    let followed = best(tried.collect());
    best(followed.par_iter().filter_map(|f| estimated(PATIENCE, &f.model, &f.states, data, ALL)).collect())
}

/// An estimate in as many steps of the integration as the estimated motion itself asks for.
pub fn estimated(
    patience: usize,
    model: &Model,
    states: &[Vec<f64>],
    data: &Data,
    folds: Folds,
) -> Option<Fitted<Model>> {
    let mut model = accurate(model, states, data)?;
    let mut states = states.to_vec();
    loop {
        let fitted = fit_in(patience, &model, &states, data, folds)?;
        let asked = accurate(&fitted.model, &fitted.states, data)?.substeps;
        if asked <= model.substeps {
            return Some(fitted);
        }
        model = Model { substeps: asked, ..fitted.model };
        states = fitted.states;
    }
}

/// The model with as many steps from row to row as its own motion asks for: so many that twice as many change nothing
/// beside what it leaves of the recording; none where that are too many, or it cannot be simulated.
pub fn accurate(model: &Model, states: &[Vec<f64>], data: &Data) -> Option<Model> {
    let rows = || data.runs.iter().flat_map(|run| run.clone());
    let square = |of: &dyn Fn(usize) -> f64| rows().map(|k| of(k).powi(2)).sum::<f64>();
    let size = square(&|k| data.position[k]);
    let mut model = Model { substeps: 1, ..model.clone() };
    let mut coarse = model.positions(states, data).ok();
    while model.substeps < MOST_SUBSTEPS {
        model.substeps *= 2;
        let fine = model.positions(states, data).ok();
        if let (Some(coarse), Some(fine)) = (&coarse, &fine) {
            let left = square(&|k| data.position[k] - fine[k]);
            let apart = square(&|k| coarse[k] - fine[k]);
            if apart <= f64::max(ACCURATE.powi(2) * size, BESIDE.powi(2) * left) {
                model.substeps /= 2;
                return Some(model);
            }
        }
        coarse = fine;
    }
    None
}
