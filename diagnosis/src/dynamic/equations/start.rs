//! Where the estimate of a plant in equations starts: points spread over the ranges of its parameters, tried on the first
//! rows of each run; the best are followed as the stretch of rows doubles, so that the phase of an oscillation never runs
//! out of step by more than an estimate can mend.

use fitter::plant::Hold;
use motion::equations::{EquationsError, Plant};
use physics::{Interval, Parameter};
use rayon::prelude::*;
use std::sync::Arc;

use super::super::data::{ALL, Data, Folds, HOLDS};
use super::super::estimate::{Fitted, Simulated, fit, fit_in};
use super::super::noise::Autoregression;
use super::super::verdict::covariance;
use super::model::{Model, is_logarithmic};
use crate::thresholds::dynamic::equations::{
    ACCURATE, AS_WELL, FIRST_PART, FOLLOWED, LEAST_FIRST, MOST_SUBSTEPS, OPEN, POINTS, STEPS, STRIDE,
};

/// The plant without further effects, fitted to all rows in the best way of running between the samples. Where other
/// parameters do as well they follow: the recording does not determine them, as an effect may that is found later. Empty
/// where no start leads to a plant that can be simulated.
///
/// # Errors
/// [`EquationsError`].
pub fn nominal(plant: &Arc<Plant>, data: &Data) -> Result<Vec<Fitted<Model>>, EquationsError> {
    let holds: Vec<Hold> = match plant.sampling {
        Some(hold) => vec![hold],
        None if plant.inputs.is_empty() => vec![Hold::ZeroOrder],
        None => HOLDS.to_vec(),
    };
    let plain = Model::new(plant.clone(), middle(plant), holds[0])?;
    let windowed = data.starts_s.iter().any(|start| *start > 0.0);
    let free_starts = plain.free_starts.iter().map(|free| *free || windowed).collect();
    let mut all = followed(&Model { free_starts, ..plain }, data);
    let others = holds[1..].par_iter().filter_map(|hold| {
        let best = all.first()?;
        fit(&Model { hold: *hold, ..best.model.clone() }, &best.states, data, ALL)
    });
    let others: Vec<Fitted<Model>> = others.collect();
    all.extend(others);
    sort(&mut all);
    all.truncate(1);
    let alike = all.first().map_or_else(Vec::new, |best| alike(best, data));
    all.extend(alike);
    Ok(all)
}

/// The same plant with other parameters that do as well, along the one that the recording determines least; none where it
/// determines all. An offset that no output shows, or the unit of a hidden state, is such a one.
fn alike(best: &Fitted<Model>, data: &Data) -> Vec<Fitted<Model>> {
    let free: Vec<usize> = (0..best.model.values.len()).filter(|k| best.model.plant.is_free(*k)).collect();
    let white = Autoregression { coefficients: Vec::new(), innovation: 0.0 };
    let covariance = covariance(best, data, &white);
    let open = |number: usize| {
        let parameter = &best.model.plant.parameters[free[number]];
        let width =
            if is_logarithmic(parameter) { 1.0 } else { parameter.range.map_or(1.0, |r| r.to - r.from) };
        covariance.at(number, number).sqrt() / width
    };
    let least = (0..free.len()).map(|k| (k, open(k))).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((number, _)) = least.filter(|(_, open)| *open > OPEN) else { return Vec::new() };
    let k = free[number];
    let Some(range) = best.model.plant.parameters[k].range else { return Vec::new() };
    let walk = |direction: f64| {
        let (mut found, mut now) = (Vec::new(), best.clone());
        loop {
            let mut plant = (*now.model.plant).clone();
            let packed = direction
                * if is_logarithmic(&plant.parameters[k]) {
                    STRIDE
                } else {
                    STRIDE * (range.to - range.from)
                };
            let there = match is_logarithmic(&plant.parameters[k]) {
                true => now.model.values[k] * packed.exp(),
                false => now.model.values[k] + packed,
            };
            if !(range.from..=range.to).contains(&there) {
                return found;
            }
            plant.parameters[k].range = Some(Interval { from: there, to: there });
            let mut model = Model { plant: Arc::new(plant), ..now.model.clone() };
            model.values[k] = there;
            let Some(next) = fit(&model, &now.states, data, ALL) else { return found };
            if next.cost(ALL) > AS_WELL * best.cost(ALL) {
                return found;
            }
            now = Fitted { model: Model { plant: best.model.plant.clone(), ..next.model.clone() }, ..next };
            found.push(now.clone());
        }
    };
    let (up, down) = rayon::join(|| walk(1.0), || walk(-1.0));
    up.into_iter().chain(down).collect()
}

fn sort(all: &mut [Fitted<Model>]) {
    all.sort_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)));
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

/// The best estimates over all starts, on all rows.
fn followed(plain: &Model, data: &Data) -> Vec<Fitted<Model>> {
    let rows = data.runs.iter().map(|run| run.len()).max().unwrap_or(0);
    let mut length = (rows / FIRST_PART).max(LEAST_FIRST);
    let head = data.clone().head(length);
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
        fit_in(0, &model, &states, &head, ALL)
    });
    let mut tried: Vec<Fitted<Model>> = tried.collect();
    loop {
        sort(&mut tried);
        tried.truncate(FOLLOWED);
        let stretch = data.clone().head(length);
        let further = |f: &Fitted<Model>| {
            let model = accurate(&f.model, &f.states, &stretch)?;
            if length < rows {
                fit_in(STEPS, &model, &f.states, &stretch, ALL)
            } else {
                fit(&model, &f.states, data, ALL)
            }
        };
        let next: Vec<Fitted<Model>> = tried.par_iter().filter_map(further).collect();
        tried = next;
        if length >= rows || tried.is_empty() {
            return tried;
        }
        length *= 2;
    }
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
/// that could be seen; none where that are too many, or it cannot be simulated.
pub fn accurate(model: &Model, states: &[Vec<f64>], data: &Data) -> Option<Model> {
    let size = data.position.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut model = Model { substeps: 1, ..model.clone() };
    let mut coarse = model.positions(states, data).ok();
    while model.substeps < MOST_SUBSTEPS {
        model.substeps *= 2;
        let fine = model.positions(states, data).ok();
        if let (Some(coarse), Some(fine)) = (&coarse, &fine) {
            let apart = data.runs.iter().flat_map(|run| run.clone()).map(|k| (coarse[k] - fine[k]).abs());
            if apart.fold(0.0, f64::max) <= ACCURATE * size {
                model.substeps /= 2;
                return Some(model);
            }
        }
        coarse = fine;
    }
    None
}
