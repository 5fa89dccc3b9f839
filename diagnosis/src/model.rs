//! The augmented model: base polynomial and named effects, fitted jointly in the whitened metric, with
//! intervals of every parameter that allow for the others and for the shape parameters.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::averaging::rivals;
use crate::base::base_columns;
use crate::calibrate::log_tail;
use crate::dictionary::{Kind, highest_order};
use crate::effects::{Effect, Reading};
use crate::explain::{Explanation, first_order};
use crate::intervals::{Beside, widening};
use crate::linear::{Basis, dot, least_squares};
use crate::noise::Noise;
use crate::rows::{Rows, rms};
use crate::search::{Search, Term};
use crate::thresholds::explain::STAGE_GAIN;
use crate::thresholds::model::ORDER_SURPRISE;

/// A term with its amplitudes.
#[derive(Debug, Clone)]
pub struct FittedTerm {
    /// The term.
    pub term: Term,
    /// Index in the catalogue; none for a generic term.
    pub effect: Option<usize>,
    /// Amplitudes of its columns.
    pub amplitudes: Vec<f64>,
    /// Covariance of the amplitudes, by rows.
    pub covariance: Vec<f64>,
    /// What it adds to the error at every row.
    pub contribution: Vec<f64>,
    /// Its reported parameters with 95 % intervals.
    pub parameters: Vec<(Reading, [f64; 2])>,
    /// Sum of squares that it alone explains beside the others.
    pub explained: f64,
    /// The part of it that reaches other recordings of the device: less than 1 where something that happened at one time
    /// of this recording may be what is seen.
    pub reach: f64,
}

/// The augmented model.
#[derive(Debug, Clone)]
pub struct Model {
    /// Order of the base polynomial.
    pub order: usize,
    /// Coefficients of [`base_columns`].
    pub base: Vec<f64>,
    /// The base at every row.
    pub base_value: Vec<f64>,
    /// The terms.
    pub terms: Vec<FittedTerm>,
    /// Covariance of `base` and after it of all terms' amplitudes, by rows.
    pub covariance: Vec<f64>,
}

impl Model {
    /// What the model says of every row.
    pub fn value(&self) -> Vec<f64> {
        let mut value = self.base_value.clone();
        for term in &self.terms {
            value.iter_mut().zip(&term.contribution).for_each(|(v, c)| *v += c);
        }
        value
    }
}

/// The lowest order of the base beyond which nothing is gained, beside the given terms.
pub fn choose_order(explanation: &Explanation, terms: &[Term]) -> usize {
    let search = &explanation.search;
    let rows = search.rows;
    let highest = highest_order(rows);
    if rows.order.is_some() {
        return highest;
    }
    let lowest = if rows.pair { 3.min(highest) } else { 1 };
    let n = rows.len();
    let mut basis = Basis::new(n);
    let all = base_columns(rows, highest);
    for column in all.iter().take(lowest + 1).chain(terms.iter().flat_map(|t| t.columns.iter())) {
        basis.add(&search.noise.whiten(column));
    }
    let mut residual = search.noise.whiten(&search.noise.clean);
    basis.project_off(&mut residual);
    if explanation.gross {
        return simplest_order(rows, terms, lowest, &all);
    }
    // Where structure is left that no order follows, it is the noise that an order is judged by.
    let mut highest_basis = basis.clone();
    for column in &all[lowest + 1..] {
        highest_basis.add(&search.noise.whiten(column));
    }
    let mut rest = residual.clone();
    highest_basis.project_off(&mut rest);
    let level = (dot(&rest, &rest) / (n as f64 - highest_basis.rank() as f64).max(1.0)).max(1.0);
    let mut order = lowest;
    let mut gained = 0.0;
    for (k, column) in all.iter().enumerate().skip(lowest + 1) {
        let before = basis.rank();
        basis.add(&search.noise.whiten(column));
        if basis.rank() > before {
            let q = basis.columns.get(before);
            let a = dot(q, &residual);
            crate::linear::add_scaled(&mut residual, -a, q);
            gained += a * a / level;
        }
        // An even order may bring nothing where the next odd one does: judged over the block since `order`.
        if log_tail(gained, k - order) > ORDER_SURPRISE {
            order = k;
            gained = 0.0;
        }
    }
    order
}

/// The lowest order of the base beside which a higher one makes what is left hardly smaller: where structure is left in
/// any case, orders follow it.
fn simplest_order(rows: &Rows, terms: &[Term], lowest: usize, all: &[Vec<f64>]) -> usize {
    let mut basis = Basis::new(rows.len());
    for column in all.iter().take(lowest + 1).chain(terms.iter().flat_map(|t| t.columns.iter())) {
        basis.add(column);
    }
    let mut residual = rows.error.clone();
    basis.project_off(&mut residual);
    let mut left = vec![rms(&residual)];
    for column in &all[lowest + 1..] {
        basis.add(column);
        basis.project_off(&mut residual);
        left.push(rms(&residual));
    }
    let least = left.last().copied().unwrap_or(0.0);
    lowest + left.iter().position(|left| STAGE_GAIN * left <= least).unwrap_or(0)
}

/// Fits base and terms jointly, without anything about parameters: what is needed to predict.
pub fn predictive(explanation: &Explanation, terms: &[Term], order: usize) -> Model {
    let search = &explanation.search;
    let rows = search.rows;
    let noise = &search.noise;
    let base = base_columns(rows, order);
    let undetermined = undetermined_rows(search, terms);
    let raw: Vec<&Vec<f64>> =
        base.iter().chain(terms.iter().flat_map(|t| t.columns.iter())).chain(&undetermined).collect();
    let whitened: Vec<Vec<f64>> = raw.iter().map(|c| noise.whiten(c)).collect();
    let solution = least_squares(&whitened, &noise.whiten(&noise.clean));
    let sum = |coefficients: &[f64], columns: &[&Vec<f64>]| {
        let mut sum = vec![0.0; rows.len()];
        coefficients.iter().zip(columns).for_each(|(a, c)| crate::linear::add_scaled(&mut sum, *a, c));
        sum
    };
    let p = raw.len();
    let mut first = base.len();
    let fitted = terms
        .iter()
        .map(|term| {
            let own = first..first + term.columns.len();
            first = own.end;
            FittedTerm {
                term: term.clone(),
                effect: search.effect(term.family),
                amplitudes: solution.coefficients[own.clone()].to_vec(),
                covariance: own
                    .clone()
                    .flat_map(|i| own.clone().map(move |k| (i, k)))
                    .map(|(i, k)| solution.inverse[i * p + k])
                    .collect(),
                contribution: sum(&solution.coefficients[own.clone()], &raw[own]),
                parameters: Vec::new(),
                explained: 0.0,
                reach: 1.0,
            }
        })
        .collect();
    Model {
        order,
        base: solution.coefficients[..base.len()].to_vec(),
        base_value: sum(&solution.coefficients[..base.len()], &raw[..base.len()]),
        terms: fitted,
        covariance: (0..first * first).map(|k| solution.inverse[k / first * p + k % first]).collect(),
    }
}

/// Fits base and terms jointly. `order` none chooses it.
pub fn fit(
    explanation: &Explanation,
    catalogue: &[Box<dyn Effect>],
    terms: &[Term],
    order: Option<usize>,
) -> Model {
    let search = &explanation.search;
    let rows = search.rows;
    let noise = &search.noise;
    let terms: Vec<Term> = terms
        .iter()
        .filter(|t| !matches!(search.dictionary.families[t.family].kind, Kind::Order))
        .cloned()
        .collect();
    // The order that the search absorbed at least: one that the recording shows to be needless is no harm, one
    // that is missing bends the effects and makes their intervals too narrow.
    let order = order.unwrap_or_else(|| choose_order(explanation, &terms).max(first_order(rows)));
    let base = base_columns(rows, order);
    let undetermined = undetermined_rows(search, &terms);
    let target = noise.whiten(&noise.clean);
    let solve = |terms: &[Term]| {
        let raw = base.iter().chain(terms.iter().flat_map(|t| t.columns.iter())).chain(&undetermined);
        let columns: Vec<Vec<f64>> = raw.map(|c| noise.whiten(c)).collect();
        let solution = least_squares(&columns, &target);
        (columns, solution)
    };
    let (mut columns, mut solution) = solve(&terms);
    let mut terms = terms;
    if place_steps(rows, noise, catalogue, search, &base, &mut terms, &solution.coefficients) {
        (columns, solution) = solve(&terms);
    }
    let left = without_steps(rows, &base, &terms, &solution.coefficients, |t| {
        search.effect(t.family).is_some_and(|e| catalogue[e].begins_at_a_row)
    });

    // Intervals: the amplitudes' covariance with the shapes' tangents beside them.
    let mut tangents = columns.clone();
    let mut places: Vec<Vec<Option<usize>>> = Vec::new();
    let mut first = base.len();
    for term in &terms {
        let width = term.columns.len();
        let amplitudes = &solution.coefficients[first..first + width];
        first += width;
        let mut place = Vec::new();
        if let Some(e) = search.effect(term.family) {
            for (k, step) in tangent_steps(catalogue[e].as_ref(), rows, &term.shape).into_iter().enumerate() {
                place.push(step.map(|h| {
                    tangents.push(noise.whiten(&tangent(
                        catalogue[e].as_ref(),
                        rows,
                        &term.shape,
                        amplitudes,
                        k,
                        h,
                    )));
                    tangents.len() - 1
                }));
            }
        }
        places.push(place);
    }
    let with_tangents = least_squares(&tangents, &target);
    let mut whole_basis = Basis::new(rows.len());
    tangents.iter().for_each(|column| {
        whole_basis.add(column);
    });
    let mut whole_residual = target.clone();
    whole_basis.project_off(&mut whole_residual);
    let p = tangents.len();
    let freedom = noise.freedom.min((rows.len() as f64 - p as f64).max(1.0));

    let whole: f64 = solution.rss;
    let mut fitted = Vec::new();
    let mut first = base.len();
    for (index, term) in terms.iter().enumerate() {
        let width = term.columns.len();
        let amplitudes = solution.coefficients[first..first + width].to_vec();
        let mut contribution = vec![0.0; rows.len()];
        for (a, column) in amplitudes.iter().zip(term.columns.iter()) {
            crate::linear::add_scaled(&mut contribution, *a, column);
        }
        let without: Vec<Vec<f64>> = columns
            .iter()
            .enumerate()
            .filter(|(k, _)| !(first..first + width).contains(k))
            .map(|(_, c)| c.clone())
            .collect();
        let explained = least_squares(&without, &target).rss - whole;
        let mut positions: Vec<Option<usize>> = (first..first + width).map(Some).collect();
        positions.extend(places[index].iter().copied());
        let covariance_of = |a: usize, b: usize| match (positions[a], positions[b]) {
            (Some(i), Some(j)) => with_tangents.inverse[i * p + j],
            _ => 0.0,
        };
        let effect = search.effect(term.family);
        let parameters = effect.map_or_else(Vec::new, |e| {
            // The other effects' columns and tangents: everything but this effect's own.
            let own: Vec<usize> = positions.iter().flatten().copied().collect();
            let mut basis = Basis::new(rows.len());
            for (_, column) in tangents.iter().enumerate().filter(|(k, _)| !own.contains(k)) {
                basis.add(column);
            }
            let mut residual = target.clone();
            basis.project_off(&mut residual);
            // The direction of its first amplitude: what is its own beside everything else.
            let mut direction = columns[first].clone();
            basis.project_off(&mut direction);
            let widening = widening(freedom) * crate::memory::spread(noise, &direction, &whole_residual);
            let beside = Beside { rows, noise, basis, residual, widening, left: &left[index] };
            let effect = catalogue[e].as_ref();
            let rivals = rivals(search, effect, &terms, &whole_basis, &whole_residual);
            beside.parameters(effect, &term.shape, &amplitudes, &rivals)
        });
        let covariance = (0..width * width).map(|k| covariance_of(k / width, k % width)).collect();
        fitted.push(FittedTerm {
            term: term.clone(),
            effect,
            amplitudes,
            covariance,
            contribution,
            parameters,
            explained,
            reach: 1.0,
        });
        first += width;
    }
    let coefficients = solution.coefficients[..base.len()].to_vec();
    let mut base_value = vec![0.0; rows.len()];
    for (a, column) in coefficients.iter().zip(&base) {
        crate::linear::add_scaled(&mut base_value, *a, column);
    }
    // `first` columns are the base's and the amplitudes'; what follows them are tangents.
    let covariance = (0..first * first).map(|k| with_tangents.inverse[k / first * p + k % first]).collect();
    Model { order, base: coefficients, base_value, terms: fitted, covariance }
}

/// One column for every row at which the signature of a term is not determined: 1 there and 0 elsewhere. Beside them the
/// fit is that of the other rows, also in correlated noise.
fn undetermined_rows(search: &Search, terms: &[Term]) -> Vec<Vec<f64>> {
    let rows = search.rows;
    let effects = terms.iter().filter_map(|t| search.effect(t.family));
    let alone: BTreeSet<usize> =
        effects.flat_map(|e| search.catalogue[e].undetermined_rows(rows, search.noise.level)).collect();
    let column = |row: usize| (0..rows.len()).map(|i| f64::from(u8::from(i == row))).collect();
    alone.into_iter().map(column).collect()
}

/// What the observations as they were read leave without each term for which `wanted` holds; empty for others.
fn without_steps(
    rows: &Rows,
    base: &[Vec<f64>],
    terms: &[Term],
    coefficients: &[f64],
    wanted: impl Fn(&Term) -> bool,
) -> Vec<Vec<f64>> {
    let mut residual = rows.error.clone();
    let raw = base.iter().chain(terms.iter().flat_map(|t| t.columns.iter()));
    for (a, column) in coefficients.iter().zip(raw) {
        crate::linear::add_scaled(&mut residual, -a, column);
    }
    let mut first = base.len();
    terms
        .iter()
        .map(|term| {
            let at = first;
            first += term.columns.len();
            if !wanted(term) {
                return Vec::new();
            }
            let mut left = residual.clone();
            for (a, column) in coefficients[at..].iter().zip(term.columns.iter()) {
                crate::linear::add_scaled(&mut left, *a, column);
            }
            left
        })
        .collect()
}

/// Puts every step at its likeliest row; whether any moved.
fn place_steps(
    rows: &Rows,
    noise: &Noise,
    catalogue: &[Box<dyn Effect>],
    search: &Search,
    base: &[Vec<f64>],
    terms: &mut [Term],
    coefficients: &[f64],
) -> bool {
    let step = |t: &Term| search.effect(t.family).filter(|e| catalogue[*e].begins_at_a_row);
    let left = without_steps(rows, base, terms, coefficients, |t| step(t).is_some());
    let mut first = base.len();
    let mut moved = false;
    for (term, left) in terms.iter_mut().zip(&left) {
        let height = coefficients[first];
        first += term.columns.len();
        let Some(e) = step(term) else { continue };
        let row = crate::steps::beginning(left, noise, height, term.shape[0] as usize, &rows.t_s);
        if row as f64 != term.shape[0] {
            term.shape[0] = row as f64;
            term.columns = Arc::new(catalogue[e].signature(rows, &term.shape));
            moved = true;
        }
    }
    moved
}

/// Step of the numerical derivative for every shape parameter; none for one that is fixed or whole.
fn tangent_steps(effect: &dyn Effect, rows: &Rows, shape: &[f64]) -> Vec<Option<f64>> {
    if effect.shape_follows {
        return vec![None; shape.len()];
    }
    effect
        .ranges(rows)
        .iter()
        .zip(shape)
        .map(|(r, v)| {
            (!r.whole && r.high > r.low)
                .then(|| if r.logarithmic { 1e-3 * v } else { 1e-4 * (r.high - r.low) })
        })
        .collect()
}

/// Derivative of the contribution with respect to shape parameter `k`.
fn tangent(
    effect: &dyn Effect,
    rows: &Rows,
    shape: &[f64],
    amplitudes: &[f64],
    k: usize,
    h: f64,
) -> Vec<f64> {
    let at = |value: f64| {
        let mut moved = shape.to_vec();
        moved[k] = value;
        let mut sum = vec![0.0; rows.len()];
        for (a, column) in amplitudes.iter().zip(effect.signature(rows, &moved)) {
            crate::linear::add_scaled(&mut sum, *a, &column);
        }
        sum
    };
    let (up, down) = (at(shape[k] + h), at(shape[k] - h));
    up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * h)).collect()
}

/// The base alone, of the order that `fit` chooses where there is one: what is handed on where nothing has a name.
pub fn expected(explanation: &Explanation, catalogue: &[Box<dyn Effect>], order: Option<usize>) -> Model {
    let rows = explanation.search.rows;
    let own = || choose_order(explanation, &[]).max(rows.order.unwrap_or(first_order(rows).min(3)));
    fit(explanation, catalogue, &[], Some(order.map_or_else(own, |order| order.min(highest_order(rows)))))
}
