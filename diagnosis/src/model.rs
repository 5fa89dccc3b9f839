//! The augmented model: base polynomial and named effects, fitted jointly in the whitened metric, with
//! intervals of every parameter that allow for the others and for the shape parameters.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use numerics::{Basis, LeastSquares, add_scaled, dot, least_squares, rms};

use crate::averaging::rivals;
use crate::base::base_columns;
use crate::calibrate::log_tail;
use crate::dictionary::highest_order;
use crate::effects::{Effect, Reading};
use crate::explain::{Explanation, first_order};
use crate::intervals::{Beside, widening};
use crate::rows::Rows;
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
        basis.add(&search.whitener.whiten(column));
    }
    let mut residual = search.whitener.whiten(&search.noise.clean);
    basis.project_off(&mut residual);
    if explanation.gross {
        return simplest_order(rows, terms, lowest, &all);
    }
    // Where structure is left that no order follows, it is the noise that an order is judged by.
    let mut highest_basis = basis.clone();
    for column in &all[lowest + 1..] {
        highest_basis.add(&search.whitener.whiten(column));
    }
    let mut rest = residual.clone();
    highest_basis.project_off(&mut rest);
    let level = (dot(&rest, &rest) / (n as f64 - highest_basis.rank() as f64).max(1.0)).max(1.0);
    let mut order = lowest;
    let mut gained = 0.0;
    for (k, column) in all.iter().enumerate().skip(lowest + 1) {
        let before = basis.rank();
        basis.add(&search.whitener.whiten(column));
        if basis.rank() > before {
            let q = basis.columns.get(before);
            let a = dot(q, &residual);
            add_scaled(&mut residual, -a, q);
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

/// Base, terms and undetermined rows, fitted jointly in the whitened metric.
struct Joint {
    order: usize,
    base: Vec<Vec<f64>>,
    /// Whitened.
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    solution: LeastSquares,
}

impl Joint {
    fn of(search: &Search, terms: &[Term], order: usize) -> Joint {
        let whitener = &search.whitener;
        let base = base_columns(search.rows, order);
        let undetermined = undetermined_rows(search, terms);
        let raw = base.iter().chain(terms.iter().flat_map(|t| t.columns.iter())).chain(&undetermined);
        let columns: Vec<Vec<f64>> = raw.map(|c| whitener.whiten(c)).collect();
        let target = whitener.whiten(&search.noise.clean);
        let solution = least_squares(&columns, &target);
        Joint { order, base, columns, target, solution }
    }

    /// Every term with its place among the columns.
    fn places<'t>(&self, terms: &'t [Term]) -> Vec<(&'t Term, Range<usize>)> {
        let mut first = self.base.len();
        let place = |term: &'t Term| {
            let own = first..first + term.columns.len();
            first = own.end;
            (term, own)
        };
        terms.iter().map(place).collect()
    }

    /// The model without anything about parameters; `inverse` is that of the products of at least these columns, by rows.
    fn model(&self, search: &Search, terms: &[Term], inverse: &[f64]) -> Model {
        let coefficients = &self.solution.coefficients;
        let p = inverse.len().isqrt();
        let covariance = |of: Range<usize>| -> Vec<f64> {
            of.clone().flat_map(|i| of.clone().map(move |k| inverse[i * p + k])).collect()
        };
        let sum = |own: Range<usize>, columns: &[Vec<f64>]| {
            let mut sum = vec![0.0; search.rows.len()];
            coefficients[own].iter().zip(columns).for_each(|(a, c)| add_scaled(&mut sum, *a, c));
            sum
        };
        let fitted = |(term, own): (&Term, Range<usize>)| FittedTerm {
            term: term.clone(),
            effect: search.effect(term.family),
            amplitudes: coefficients[own.clone()].to_vec(),
            covariance: covariance(own.clone()),
            contribution: sum(own, &term.columns),
            parameters: Vec::new(),
            explained: 0.0,
            reach: 1.0,
        };
        let places = self.places(terms);
        let (base, last) = (0..self.base.len(), places.last().map_or(self.base.len(), |(_, own)| own.end));
        Model {
            order: self.order,
            base: coefficients[base.clone()].to_vec(),
            base_value: sum(base, &self.base),
            terms: places.into_iter().map(fitted).collect(),
            covariance: covariance(0..last),
        }
    }
}

/// Fits base and terms jointly, without anything about parameters: what is needed to predict.
pub fn predictive(explanation: &Explanation, terms: &[Term], order: usize) -> Model {
    let joint = Joint::of(&explanation.search, terms, order);
    joint.model(&explanation.search, terms, &joint.solution.inverse)
}

/// Fits base and terms jointly. `order` none chooses it.
pub fn fit(explanation: &Explanation, catalogue: &[Effect], terms: &[Term], order: Option<usize>) -> Model {
    let search = &explanation.search;
    let rows = search.rows;
    let mut terms: Vec<Term> = terms.iter().filter(|t| !search.is_order(t.family)).cloned().collect();
    // The order that the search absorbed at least: one that the recording shows to be needless is no harm, one
    // that is missing bends the effects and makes their intervals too narrow.
    let order = order.unwrap_or_else(|| choose_order(explanation, &terms).max(first_order(rows)));
    let mut joint = Joint::of(search, &terms, order);
    if place_steps(catalogue, search, &joint, &mut terms) {
        joint = Joint::of(search, &terms, order);
    }
    let left = without_steps(search, catalogue, &joint, &terms);
    let tangents = Tangents::of(search, catalogue, &joint, &terms);
    let with_tangents = least_squares(&tangents.columns, &joint.target);
    let mut model = joint.model(search, &terms, &with_tangents.inverse);
    for (index, (term, own)) in joint.places(&terms).into_iter().enumerate() {
        let columns = joint.columns.iter().enumerate().filter(|(k, _)| !own.contains(k));
        let without: Vec<Vec<f64>> = columns.map(|(_, c)| c.clone()).collect();
        let fitted = &mut model.terms[index];
        fitted.explained = least_squares(&without, &joint.target).rss - joint.solution.rss;
        let Some(effect) = fitted.effect.map(|e| &catalogue[e]) else { continue };
        let beside = tangents.beside(search, &joint, own.start, index, &left[index]);
        let rivals = rivals(search, effect, &terms, &tangents.basis, &tangents.residual);
        fitted.parameters = beside.parameters(effect, &term.shape, &fitted.amplitudes, &rivals);
    }
    model
}

/// Moves shapes that lie at an end of what the recording allows, or outside it, to its middle: see [`Beside::settled`].
pub fn settle_shapes(explanation: &mut Explanation, catalogue: &[Effect]) {
    let fitted: Vec<Term> =
        explanation.terms.iter().filter(|t| !explanation.search.is_order(t.family)).cloned().collect();
    let order = choose_order(explanation, &fitted).max(first_order(explanation.search.rows));
    let Explanation { search, terms, .. } = explanation;
    let joint = Joint::of(search, &fitted, order);
    let left = without_steps(search, catalogue, &joint, &fitted);
    let tangents = Tangents::of(search, catalogue, &joint, &fitted);
    let mut shapes = joint.places(&fitted).into_iter().enumerate().map(|(index, (term, own))| {
        let effect = &catalogue[search.effect(term.family)?];
        tangents.beside(search, &joint, own.start, index, &left[index]).settled(effect, &term.shape)
    });
    for term in terms.iter_mut().filter(|t| !search.is_order(t.family)) {
        let (Some(Some(shape)), Some(e)) = (shapes.next(), search.effect(term.family)) else { continue };
        term.columns = Arc::new(catalogue[e].signature(search.rows, &shape));
        term.shape = shape;
    }
}

/// The whitened columns with the tangents of the shapes beside them, which the intervals allow for.
struct Tangents {
    columns: Vec<Vec<f64>>,
    /// For every term its columns and tangents.
    of_term: Vec<Vec<usize>>,
    /// Of all columns, and what they leave.
    basis: Basis,
    residual: Vec<f64>,
}

impl Tangents {
    fn of(search: &Search, catalogue: &[Effect], joint: &Joint, terms: &[Term]) -> Tangents {
        let rows = search.rows;
        let mut columns = joint.columns.clone();
        let mut of_term = Vec::new();
        for (term, own) in joint.places(terms) {
            let amplitudes = &joint.solution.coefficients[own.clone()];
            let mut all: Vec<usize> = own.collect();
            if let Some(effect) = search.effect(term.family).map(|e| &catalogue[e]) {
                for (k, step) in tangent_steps(effect, rows, &term.shape).into_iter().enumerate() {
                    let Some(h) = step else { continue };
                    let tangent = tangent(effect, rows, &term.shape, amplitudes, k, h);
                    all.push(columns.len());
                    columns.push(search.whitener.whiten(&tangent));
                }
            }
            of_term.push(all);
        }
        let mut basis = Basis::new(rows.len());
        columns.iter().for_each(|column| {
            basis.add(column);
        });
        let mut residual = joint.target.clone();
        basis.project_off(&mut residual);
        Tangents { columns, of_term, basis, residual }
    }

    /// What a term of an effect is judged beside: everything but its own columns and tangents.
    fn beside<'a>(
        &self,
        search: &'a Search,
        joint: &Joint,
        first: usize,
        index: usize,
        left: &'a [f64],
    ) -> Beside<'a> {
        let (rows, noise, whitener) = (search.rows, &search.noise, &search.whitener);
        let mut basis = Basis::new(rows.len());
        for (_, column) in self.columns.iter().enumerate().filter(|(k, _)| !self.of_term[index].contains(k)) {
            basis.add(column);
        }
        let mut residual = joint.target.clone();
        basis.project_off(&mut residual);
        // The direction of its first amplitude: what is its own beside everything else.
        let mut direction = joint.columns[first].clone();
        basis.project_off(&mut direction);
        let freedom = noise.freedom.min((rows.len() as f64 - self.columns.len() as f64).max(1.0));
        let widening = widening(freedom) * crate::memory::spread(noise, &direction, &self.residual);
        let scatter_of_places = rows.scatter_of_places();
        Beside { rows, noise, whitener, basis, residual, widening, scatter_of_places, left }
    }
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

/// What the observations as they were read leave without each step; empty for other terms.
fn without_steps(search: &Search, catalogue: &[Effect], joint: &Joint, terms: &[Term]) -> Vec<Vec<f64>> {
    let coefficients = &joint.solution.coefficients;
    let mut residual = search.rows.error.clone();
    let raw = joint.base.iter().chain(terms.iter().flat_map(|t| t.columns.iter()));
    for (a, column) in coefficients.iter().zip(raw) {
        add_scaled(&mut residual, -a, column);
    }
    let left = |(term, own): (&Term, Range<usize>)| {
        if !search.effect(term.family).is_some_and(|e| catalogue[e].begins_at_a_row) {
            return Vec::new();
        }
        let mut left = residual.clone();
        coefficients[own].iter().zip(term.columns.iter()).for_each(|(a, c)| add_scaled(&mut left, *a, c));
        left
    };
    joint.places(terms).into_iter().map(left).collect()
}

/// Puts every step at its likeliest row; whether any moved.
fn place_steps(catalogue: &[Effect], search: &Search, joint: &Joint, terms: &mut [Term]) -> bool {
    let rows = search.rows;
    let left = without_steps(search, catalogue, joint, terms);
    let heights = joint.places(terms).into_iter().map(|(_, own)| joint.solution.coefficients[own.start]);
    let heights: Vec<f64> = heights.collect();
    let mut moved = false;
    for ((term, left), height) in terms.iter_mut().zip(&left).zip(heights) {
        let Some(e) = search.effect(term.family).filter(|_| !left.is_empty()) else { continue };
        let row = crate::steps::beginning(left, &search.noise, height, term.shape[0] as usize, &rows.t_s);
        if row as f64 != term.shape[0] {
            term.shape[0] = row as f64;
            term.columns = Arc::new(catalogue[e].signature(rows, &term.shape));
            moved = true;
        }
    }
    moved
}

/// Step of the numerical derivative for every shape parameter; none for one that is fixed or whole.
fn tangent_steps(effect: &Effect, rows: &Rows, shape: &[f64]) -> Vec<Option<f64>> {
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
fn tangent(effect: &Effect, rows: &Rows, shape: &[f64], amplitudes: &[f64], k: usize, h: f64) -> Vec<f64> {
    let at = |value: f64| {
        let mut moved = shape.to_vec();
        moved[k] = value;
        let mut sum = vec![0.0; rows.len()];
        for (a, column) in amplitudes.iter().zip(effect.signature(rows, &moved)) {
            add_scaled(&mut sum, *a, &column);
        }
        sum
    };
    let (up, down) = (at(shape[k] + h), at(shape[k] - h));
    up.iter().zip(&down).map(|(u, d)| (u - d) / (2.0 * h)).collect()
}

/// The base alone, of the order that `fit` chooses where there is one: what is handed on where nothing has a name.
pub fn expected(explanation: &Explanation, catalogue: &[Effect], order: Option<usize>) -> Model {
    let rows = explanation.search.rows;
    let own = || choose_order(explanation, &[]).max(rows.order.unwrap_or(first_order(rows).min(3)));
    fit(explanation, catalogue, &[], Some(order.map_or_else(own, |order| order.min(highest_order(rows)))))
}
