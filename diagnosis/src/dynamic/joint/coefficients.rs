//! An inverse model in packed parameters: coefficients of the drive in the columns of the mechanism and its effects, then shapes
//! of the effects, in which it is linear near by.

use crate::dynamic::effects::{DynamicEffect, Part};
use crate::dynamic::feedback::inverse::{
    Column, Solved, effect_columns, model_columns, normal_equations, solve,
};
use crate::dynamic::feedback::motion::Motion;
use crate::dynamic::model::Model;
use crate::thresholds::compare::joint::{FAR, POLISHING, SHAPE_STEP, UNDETERMINED};

/// A model with the shapes that its own recording prefers: the search leaves them near by.
pub fn polished(model: &Model, motion: &Motion) -> Model {
    let (mut best, mut tried, mut left) = (model.clone(), model.clone(), f64::INFINITY);
    for _ in 0..POLISHING {
        let Some(fitted) = Linearised::of(&tried, motion, &|_| true) else { break };
        let now = motion.rms(&fitted.solved.residual);
        if now >= left {
            break;
        }
        (best, left) = (fitted.solved.model, now);
        tried = best.clone();
        let first = fitted.packed.len() - shapes_of(&best).count();
        for ((k, j), to) in shapes_of(&best).zip(&fitted.packed[first..]) {
            let (from, size) = (best.terms[k].parameters[j], size_of(&best, (k, j)));
            tried.terms[k].parameters[j] = to.clamp(from - 0.5 * size, from + size);
        }
    }
    best
}

/// An inverse model on some rows, its shapes to first order.
pub struct Linearised {
    /// The model with amounts.
    pub solved: Solved,
    /// Columns of the coefficients, then of the shapes.
    pub columns: Vec<Column>,
    /// The packed parameters.
    pub packed: Vec<f64>,
    /// Drive less what they predict, both smoothed, all rows.
    pub residual: Vec<f64>,
}

impl Linearised {
    /// Fitted to the rows that are wanted, about the shapes of a model.
    pub fn of(shapes: &Model, motion: &Motion, wanted: &dyn Fn(usize) -> bool) -> Option<Linearised> {
        let solved = solve(shapes, motion, wanted)?;
        let model = &solved.model;
        let mut columns = model_columns(&solved, motion);
        columns.extend(shapes_of(model).map(|(k, j)| (by_shape(model, (k, j), motion), Some((k, j)))));
        let rows: Vec<usize> = motion.rows().filter(|row| wanted(*row)).collect();
        let sizes: Vec<f64> = shapes_of(model).map(|owner| size_of(model, owner)).collect();
        let first = columns.len() - sizes.len();
        let variance = motion.rms(&solved.residual).powi(2) / motion.independent_per_row();
        let step = loop {
            let (normal, right) = normal_equations(&columns, &rows, &solved.residual);
            let factor = normal.factor();
            let inverse = factor.inverse();
            let error = |k: usize| (variance * inverse.at(first + k, first + k)).sqrt();
            let undetermined = |k: &usize| error(*k) > UNDETERMINED * sizes[*k];
            // Without a column the rows say nothing of it.
            match (0..sizes.len()).find(undetermined) {
                Some(k) => columns[first + k].0.fill(0.0),
                None => break factor.solve(&right),
            }
        };
        let shapes = shapes_of(model).map(|(k, j)| model.terms[k].parameters[j]);
        let packed: Vec<f64> = coefficients(model).into_iter().chain(shapes).collect();
        let packed = packed.iter().zip(&step).map(|(own, step)| own + step).collect();
        let left = |row: usize| {
            solved.residual[row] - columns.iter().zip(&step).map(|((c, _), by)| c[row] * by).sum::<f64>()
        };
        let residual = (0..solved.residual.len()).map(left).collect();
        Some(Linearised { solved, columns, packed, residual })
    }
}

/// By how much a shape of a term changes before it is another one: by itself, or a place by its width.
fn size_of(model: &Model, (k, j): (usize, usize)) -> f64 {
    let term = &model.terms[k];
    if term.effect.parameters[j].place { term.parameters[j + 1] } else { term.parameters[j] }
}

/// How fast the drive changes with a shape of a term.
fn by_shape(model: &Model, (k, j): (usize, usize), motion: &Motion) -> Vec<f64> {
    let term = &model.terms[k];
    let (effect, gain) = (term.effect, model.nominal[2]);
    let step = SHAPE_STEP * size_of(model, (k, j));
    let at = |by: f64| {
        let mut shapes = term.parameters.clone();
        shapes[j] += by;
        effect_columns(effect, &shapes, motion, gain)
    };
    let mut slope = vec![0.0; motion.position.len()];
    for ((amount, more), (_, less)) in at(step).into_iter().zip(at(-step)) {
        let factor = term.parameters[amount] / gain / (2.0 * step);
        slope.iter_mut().zip(more.iter().zip(&less)).for_each(|(s, (a, b))| *s += factor * (a - b));
    }
    slope
}

/// The shapes of a model that are estimated, of which term which parameter: those that a search fits, of effects without memory.
/// What crosses a play changes by whole rows, which has no slope.
fn shapes_of(model: &Model) -> impl Iterator<Item = (usize, usize)> + '_ {
    model.terms.iter().enumerate().flat_map(|(k, term)| {
        let effect = term.effect;
        let fitted = move |j: &usize| effect.states == 0 && is_shape(effect, *j) && *j < effect.kept;
        (0..term.parameters.len()).filter(fitted).map(move |j| (k, j))
    })
}

/// Whether a parameter of an effect is a shape: a lag, sought as one elsewhere, multiplies a column here.
pub fn is_shape(effect: &DynamicEffect, parameter: usize) -> bool {
    effect.part == Part::Force && effect.parameters[parameter].shape
}

/// Which packed parameters behind those of the mechanism are of which term which parameter: first the amounts, in the order of
/// [`model_columns`], then the shapes.
pub fn owners(model: &Model) -> Vec<(usize, (usize, usize))> {
    let nominal = 2 + usize::from(model.nominal_free[1]);
    amounts_of(model).chain(shapes_of(model)).enumerate().map(|(n, owner)| (nominal + n, owner)).collect()
}

/// The amounts of a model, of which term which parameter, in the order of [`model_columns`].
fn amounts_of(model: &Model) -> impl Iterator<Item = (usize, usize)> + '_ {
    model.terms.iter().enumerate().flat_map(|(k, term)| {
        let effect = term.effect;
        let fitted = move |j: &usize| match effect.part {
            Part::Force => !is_shape(effect, *j),
            _ => *j == 0,
        };
        (0..term.parameters.len()).filter(fitted).map(move |j| (k, j))
    })
}

/// What a coefficient of one is of a term.
pub fn of_one(model: &Model, k: usize) -> f64 {
    let [_, stiffness, gain] = model.nominal;
    match model.terms[k].effect.part {
        Part::Force => gain,
        Part::SensorOffset if stiffness != 0.0 => gain / stiffness,
        _ => 1.0,
    }
}

/// The coefficients of the drive in the columns of a model.
pub fn coefficients(model: &Model) -> Vec<f64> {
    let [damping, stiffness, gain] = model.nominal;
    let mut all = vec![1.0 / gain, damping / gain];
    all.extend(model.nominal_free[1].then_some(stiffness / gain));
    all.extend(amounts_of(model).map(|(k, j)| model.terms[k].parameters[j] / of_one(model, k)));
    all
}

/// A model of the same effects with other packed parameters.
pub fn with(model: &Model, packed: &[f64]) -> Model {
    let mut model = model.clone();
    let stiff = model.nominal_free[1];
    let gain = 1.0 / packed[0];
    model.nominal = [packed[1] * gain, if stiff { packed[2] * gain } else { 0.0 }, gain];
    for (lane, (k, j)) in owners(&model) {
        let of_one = of_one(&model, k);
        let term = &mut model.terms[k];
        let own = term.parameters[j];
        term.parameters[j] = match term.effect.parameters[j] {
            _ if !is_shape(term.effect, j) => packed[lane] * of_one,
            of if of.place => packed[lane],
            // What both recordings prefer to first order may lead too far.
            _ => packed[lane].clamp(own / FAR, own * FAR),
        };
    }
    model
}
