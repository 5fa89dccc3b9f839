//! Where the estimate of a plant in equations starts: points spread over the ranges of its parameters. An observer keeps
//! the simulation beside the recording while they are far off, and is made weaker until the simulation runs free: so an
//! oscillation never runs out of step, and a level never so far away that an estimate stops in a local minimum.

use fitter::plant::Hold;
use motion::equations::{EquationsError, Plant};
use numerics::parallel;
use physics::Parameter;
use std::sync::Arc;

use super::super::accurate::{accurate, estimated};
use super::super::data::{ALL, Data, Folds, HOLDS};
use super::super::estimate::{Fitted, Simulated, fit, fit_in};
use super::model::{Model, is_logarithmic};
use crate::thresholds::dynamic::diagnose::SEARCH_STEPS;
use crate::thresholds::dynamic::equations::{
    APART, AS_WELL, FIRST_ROWS, FOLLOWED, LEAST_FIRST, OBSERVED, POINTS, SEARCH_ROWS, STEPS, WEAKER,
};

/// A plant without further effects, fitted to all rows of the windows in which effects are searched.
pub struct Nominal<'a> {
    /// The windows.
    pub windows: Data<'a>,
    /// In the best way of running between the samples.
    pub free: Fitted<Model>,
    /// Under an observer, from the starts that did best: several where the recording leaves a parameter open, as an effect
    /// may not that is found later. The unit of a hidden state is such a one.
    pub observed: Vec<Fitted<Model>>,
}

/// Fits a plant to a recording; none where no start leads to one that can be simulated.
///
/// # Errors
/// [`EquationsError`].
pub fn nominal<'a>(plant: &Arc<Plant>, data: &Data<'a>) -> Result<Option<Nominal<'a>>, EquationsError> {
    let holds: Vec<Hold> = match plant.sampling {
        Some(hold) => vec![hold],
        None if plant.inputs.is_empty() => vec![Hold::ZeroOrder],
        None => HOLDS.to_vec(),
    };
    let plain = Model::new(plant.clone(), middle(plant), holds[0])?;
    let first = windows(data, 1);
    let windowed = first.starts_s.iter().any(|start| *start > 0.0);
    let free_starts = plain.free_starts.iter().map(|free| *free || windowed).collect();
    let tried = tried(&Model { free_starts, observed: OBSERVED, ..plain.clone() }, &first);
    let Some(found) = followed(tried, &holds, first) else { return Ok(None) };
    let windows = windows(data, found.free.model.substeps);
    if windows.runs == found.windows.runs {
        return Ok(Some(found));
    }
    let free_starts = vec![true; plain.free_starts.len()];
    let again = |f: &Fitted<Model>| {
        let model = Model { free_starts: free_starts.clone(), ..f.model.clone() };
        let states = first_states(&model, &windows);
        (model, states)
    };
    Ok(followed(found.observed.iter().map(again).collect(), &holds, windows))
}

/// The windows in which effects are searched with so many steps of the integration from row to row: a recording that can
/// be searched whole is one.
fn windows<'a>(data: &Data<'a>, substeps: usize) -> Data<'a> {
    let most = SEARCH_STEPS / substeps;
    data.windows(if data.count(ALL) <= most { most } else { SEARCH_ROWS.min(most) })
}

/// The best of some starts, estimated under their observer, then in free run.
fn followed<'a>(
    starts: Vec<(Model, Vec<Vec<f64>>)>,
    holds: &[Hold],
    windows: Data<'a>,
) -> Option<Nominal<'a>> {
    let data = &windows;
    let observed = best(parallel::filter_map(&starts, |(model, states)| estimated(model, states, data, ALL)));
    let relaxed = parallel::filter_map(&observed, |f| relaxed(f.clone(), data, ALL));
    let free = best(relaxed).into_iter().next()?;
    let held = |hold: &Hold| fit(&Model { hold: *hold, ..free.model.clone() }, &free.states, data, ALL);
    let mut all = parallel::filter_map(&holds[1..], held);
    all.insert(0, free);
    let free = best(all).into_iter().next()?;
    Some(Nominal { observed: distinct(observed, free.model.hold), free, windows })
}

/// Those that leave least, the best first.
fn best(mut all: Vec<Fitted<Model>>) -> Vec<Fitted<Model>> {
    all.sort_by(|a, b| a.cost(ALL).total_cmp(&b.cost(ALL)));
    all.truncate(FOLLOWED);
    all
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

/// An estimate that began under an observer, under ever weaker ones, and in free run in the end.
pub fn relaxed(mut fitted: Fitted<Model>, data: &Data, folds: Folds) -> Option<Fitted<Model>> {
    let rows = data.runs.iter().map(|run| run.len()).max().unwrap_or(0) as f64;
    while fitted.model.observed > 0.0 {
        let weaker = fitted.model.observed / WEAKER;
        // An observer that takes longer than the run hardly corrects anything.
        fitted.model.observed = if weaker * rows < 1.0 { 0.0 } else { weaker };
        fitted = estimated(&fitted.model, &fitted.states, data, folds)?;
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
pub fn first_states(model: &Model, data: &Data) -> Vec<Vec<f64>> {
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

/// The best starts over the ranges of the parameters, tried under an observer on the first rows.
fn tried(plain: &Model, data: &Data) -> Vec<(Model, Vec<Vec<f64>>)> {
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
    let tried = parallel::indices(0..count, |number| {
        let model = accurate(&point(number), &states, &head)?;
        fit_in(STEPS, &model, &states, &head, ALL)
    });
    best(tried.into_iter().flatten().collect()).into_iter().map(|f| (f.model, f.states)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::recording::DynamicRecording;
    use super::*;
    use fitter::plant::PlantFile;

    /// An oscillator that needs two steps from row to row, and half as many rows as can be searched with one.
    #[test]
    fn the_nominal_is_fitted_in_the_windows_of_the_search() {
        let text = "[plant]\nkind = \"equations\"\n\
                    states = { x = { unit = \"m\", start = \"fit\" }, v = { unit = \"m/s\", start = \"fit\" } }\n\
                    output = { y = \"x\" }\n[plant.equations]\nx = \"v\"\nv = \"-a * x\"\n\
                    [plant.parameters]\na = { unit = \"1/s^2\", from = 0.9, to = 1.1, value = 1.0001 }\n";
        let file = PlantFile::parse("plant.toml", text).unwrap();
        let plant = Arc::new(Plant::of("plant.toml", &file).unwrap().unwrap());
        let (rows, step_s) = (17_000, 0.4);
        let t_s: Vec<f64> = (0..rows).map(|k| step_s * k as f64).collect();
        let recording = DynamicRecording {
            further: Vec::new(),
            file: String::new(),
            sha256: String::new(),
            step_s,
            drives: vec![vec![0.0; rows].into()],
            positions: vec![t_s.iter().map(|t| t.cos()).collect()],
            t_s: t_s.into(),
            runs: std::iter::once(0..rows).collect(),
            period: None,
            amplitude: None,
            command: None,
            bad_rows: Vec::new(),
            notes: Vec::new(),
        };
        let found = nominal(&plant, &Data::new(&recording)).unwrap().unwrap();
        let windows = found.windows.runs.len();
        assert!(windows > 1 && found.free.model.substeps > 1, "{windows} {}", found.free.model.substeps);
        assert_eq!(found.free.states.len(), windows);
        assert!(found.observed.iter().all(|f| f.states.len() == windows));
        // Every window is simulated: what is left is what the steps of the integration leave.
        assert!(found.free.rms(ALL) < 1e-3, "{}", found.free.rms(ALL));
        assert!((found.free.model.values[0] - 1.0).abs() < 1e-6, "{:?}", found.free.model.values);
    }
}
