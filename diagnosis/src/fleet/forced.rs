//! What one recording says of every effect, whether it was named there or not: the normal equations of all their columns
//! beside the base.
//!
//! An estimate that is made only where an effect was found is too large: noise that made it larger also made it found. So
//! every effect is fitted in every unit, at shapes that are the same for all units, and the fit is linear: unbiased, and
//! with a standard error that does not depend on what was found.

use std::collections::BTreeSet;
use std::sync::Arc;

use numerics::{Basis, Symmetric, dot};

use crate::base::base_columns;
use crate::dictionary::Kind;
use crate::effects::{Effect, Range};
use crate::explain::{Explanation, first_order};
use crate::model::Model;
use crate::rows::Rows;
use crate::thresholds::fleet::{OWN, SET_SHAPES};

use super::Estimate;

/// One column: a factor of an effect, at a shape.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Test {
    /// Id of the effect.
    pub effect: String,
    /// The shape, as `time_constant_s=30`; blank where nothing is chosen.
    pub at: String,
    /// Name of the parameter, with its unit.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
}

/// See the module.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Forced {
    /// The columns; shared, since most units of a fleet have the same.
    pub tests: Arc<[Test]>,
    /// Behind them, columns of the effects that the diagnosis of this unit names, at the shapes that it found: the id of
    /// each. What it found and no test stands for is projected off, as the base is.
    pub terms: Vec<String>,
    /// Products of the columns with the whitened observations, per unit of each parameter.
    pub scores: Vec<f64>,
    /// Products of the columns with each other, the upper triangle by rows.
    pub information: Vec<f64>,
}

impl Forced {
    pub(crate) fn of(explanation: &Explanation, model: &Model) -> Forced {
        let search = &explanation.search;
        let (rows, whitener, catalogue) = (search.rows, &search.whitener, search.catalogue);
        let testable: BTreeSet<usize> = (search.dictionary.families.iter())
            .filter_map(|family| match family.kind {
                Kind::Effect(effect) => Some(effect),
                Kind::Generic(_) | Kind::Order => None,
            })
            .collect();
        let shapes = |effect: &usize| Some((*effect, set_shapes(&catalogue[*effect], rows)?));
        let tested: Vec<(usize, Vec<Vec<f64>>)> = testable.iter().filter_map(shapes).collect();
        let mut basis = Basis::new(rows.len());
        for column in base_columns(rows, model.order.max(first_order(rows))) {
            basis.add(&whitener.whiten(&column));
        }
        let mut terms = Vec::new();
        for term in &model.terms {
            let own = term.effect.filter(|effect| tested.iter().any(|(other, _)| other == effect));
            for column in term.term.columns.iter().map(|column| whitener.whiten(column)) {
                match own {
                    Some(effect) => terms.push((catalogue[effect].id.clone(), column)),
                    None => drop(basis.add(&column)),
                }
            }
        }
        let mut tests = Vec::new();
        let mut columns = Vec::new();
        for (effect, shape) in tested.iter().flat_map(|(e, shapes)| shapes.iter().map(move |s| (*e, s))) {
            let effect = &catalogue[effect];
            for (column, (parameter, unit)) in effect.signature(rows, shape).iter().zip(effect.factors()) {
                let whole = whitener.whiten(column);
                let mut own = whole.clone();
                basis.project_off(&mut own);
                // Also false of a column that is no number.
                if dot(&own, &own) > OWN * dot(&whole, &whole) {
                    let (effect, at) = (effect.id.clone(), said(effect, rows, shape));
                    tests.push(Test { effect, at, parameter: parameter.into(), unit: unit.into() });
                    columns.push(own);
                }
            }
        }
        let (terms, found): (Vec<String>, Vec<Vec<f64>>) = terms.into_iter().unzip();
        columns.extend(found.into_iter().map(|mut column| {
            basis.project_off(&mut column);
            column
        }));
        let target = whitener.whiten(&search.noise.clean);
        Forced {
            tests: tests.into(),
            terms,
            scores: columns.iter().map(|column| dot(column, &target)).collect(),
            information: (0..columns.len())
                .flat_map(|i| columns[i..].iter().map(move |other| (i, other)))
                .map(|(i, other)| dot(&columns[i], other))
                .collect(),
        }
    }

    /// The estimate of every test alone, beside the base and what the diagnosis of this unit names of other effects.
    pub fn alone(&self) -> Vec<Option<Estimate>> {
        (0..self.tests.len()).map(|test| self.beside(&[test], &[])[0]).collect()
    }

    /// Estimates of the parameters of some tests, fitted together beside what the diagnosis of this unit names of other effects,
    /// and beside those of `others` that it does not name: its own shape is the better one. None where the recording does not
    /// determine it.
    pub fn beside(&self, tests: &[usize], others: &[usize]) -> Vec<Option<Estimate>> {
        let effect = |test: &usize| &self.tests[*test].effect;
        let own = |k: &usize| !tests.iter().any(|test| *effect(test) == self.terms[*k]);
        let others = others.iter().filter(|other| !self.terms.contains(effect(other)));
        let named = (0..self.terms.len()).filter(own).map(|k| self.tests.len() + k);
        let lanes: Vec<usize> = tests.iter().chain(others).copied().chain(named).collect();
        let mut part = Symmetric::zero(lanes.len());
        for (i, a) in lanes.iter().enumerate() {
            for (k, b) in lanes.iter().enumerate() {
                *part.at_mut(i, k) = self.product(*a.min(b), *a.max(b));
            }
        }
        let right: Vec<f64> = lanes.iter().map(|lane| self.scores[*lane]).collect();
        let factor = part.factor();
        let (solved, inverse) = (factor.solve(&right), factor.inverse());
        let estimate = |k: usize| {
            let variance = inverse.at(k, k);
            (variance > 0.0 && solved[k].is_finite())
                .then(|| Estimate { value: solved[k], error: variance.sqrt() })
        };
        (0..tests.len()).map(estimate).collect()
    }

    /// The product of columns `a` and `b`, `a` not behind `b`.
    fn product(&self, a: usize, b: usize) -> f64 {
        let before = a * self.scores.len() - a * a.saturating_sub(1) / 2;
        self.information[before + b - a]
    }
}

/// The shapes at which an effect is fitted in every unit; none of an effect that cannot be the same in all: what happened at
/// one time belongs to a recording, and places, periods and thresholds differ from unit to unit.
fn set_shapes(effect: &Effect, rows: &Rows) -> Option<Vec<Vec<f64>>> {
    if effect.of_one_time || effect.begins_at_a_row || effect.is_form() {
        return None;
    }
    let ranges = effect.ranges(rows);
    let least: Vec<f64> = ranges.iter().map(|range| range.low).collect();
    match free(effect, &ranges)[..] {
        [] => Some(vec![least]),
        // Beside a shape, two factors are amplitude and phase of a wave.
        [k] if ranges[k].logarithmic && effect.factors().count() == 1 => {
            let within = |value: &f64| (ranges[k].low..=ranges[k].high).contains(value);
            let shape =
                |value: f64| least.iter().enumerate().map(move |(j, l)| if j == k { value } else { *l });
            let (low, high) = (ranges[k].low.log10().floor() as i32, ranges[k].high.log10().ceil() as i32);
            let values = (low..=high).flat_map(|decade| SET_SHAPES.map(|step| step * 10f64.powi(decade)));
            Some(values.filter(within).map(|value| shape(value).collect()).collect())
        }
        _ => None,
    }
}

/// The shape parameters that may take any value.
fn free(effect: &Effect, ranges: &[Range]) -> Vec<usize> {
    let is_free = |range: &Range| range.high > range.low && !range.whole;
    (0..ranges.len()).filter(|k| !effect.shape_follows && is_free(&ranges[*k])).collect()
}

/// A shape in words.
fn said(effect: &Effect, rows: &Rows, shape: &[f64]) -> String {
    let free = free(effect, &effect.ranges(rows));
    free.iter().map(|k| format!("{}={}", effect.shape_name(*k), shape[*k])).collect::<Vec<_>>().join(" ")
}
