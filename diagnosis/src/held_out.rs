//! The proof on what was not fitted: passes are held out in turn, the search is repeated on the others,
//! and base and augmented model predict the held-out rows.

use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::base::base_columns;
use crate::explain::{Explanation, first_order};
use crate::generic::saturated;
use crate::linear::least_squares;
use crate::model::{FittedTerm, Model, choose_order};
use crate::noise::Noise;
use crate::rows::{Rows, mean, rms};
use crate::search::{Search, Term};

/// Most folds.
const FOLDS: usize = 4;
/// Rows of a held-out pass count as unmeasured: their σ, in multiples of the floor.
const UNMEASURED: f64 = 1e6;

/// Root mean square of the residual on the rows that were fitted, and on those that were held out.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// On the rows that were fitted.
    pub train_rms: f64,
    /// On the held-out rows; none where nothing could be held out.
    pub held_out_rms: Option<f64>,
}

/// The proof.
#[derive(Debug, Clone, Serialize)]
pub struct Fit {
    /// Unit of the figures.
    pub unit: String,
    /// What was held out: `pass`, `block`, or the name of another recording.
    pub held_out_by: String,
    /// The base model alone.
    pub before: Score,
    /// With the named effects.
    pub after: Score,
    /// Mean over the held-out groups of rms before less rms after, with its 95 % interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<Gain>,
    /// How much of what a flexible smooth model can explain the named effects explain (1: all).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of_explainable: Option<f64>,
}

/// Predictions of the base alone and of the augmented model.
type Predicted = (Vec<f64>, Vec<f64>);

/// The improvement on held-out groups.
#[derive(Debug, Clone, Serialize)]
pub struct Gain {
    /// Mean difference of the rms.
    pub value: f64,
    /// Its paired 95 % interval.
    pub ci95: [f64; 2],
}

/// The fold in which a group is held out. Of a single move the first and the last block are never held out:
/// there the base polynomial would be asked to extrapolate, which no model of the recording promises.
fn fold_of(group: usize, count: usize, folds: usize, by: &str) -> Option<usize> {
    if by == "pass" {
        return Some(group * folds / count);
    }
    (group > 0 && group + 1 < count).then(|| (group - 1) % folds)
}

/// The group of every row: its pass, or where there is one pass a block of it.
pub fn groups(rows: &Rows) -> (Vec<usize>, usize, &'static str) {
    let passes = rows.passes();
    if passes.len() >= 2 {
        let of = |p: &i64| passes.iter().position(|q| q == p).unwrap_or(0);
        return (rows.pass.iter().map(of).collect(), passes.len(), "pass");
    }
    let blocks = (rows.len() / 20).clamp(1, 12);
    ((0..rows.len()).map(|i| i * blocks / rows.len()).collect(), blocks, "block")
}

/// Holds out every group in turn.
pub fn prove(explanation: &Explanation, before: &Model, after: &Model) -> Fit {
    let search = &explanation.search;
    let rows = search.rows;
    let residual = |m: &Model| -> Vec<f64> { rows.error.iter().zip(m.value()).map(|(e, v)| e - v).collect() };
    let (train_before, train_after) = (residual(before), residual(after));
    let (group, count, by) = groups(rows);
    let folds = count.min(FOLDS);
    let mut fit = Fit {
        unit: rows.unit.clone(),
        held_out_by: by.into(),
        before: Score { train_rms: rms(&train_before), held_out_rms: None },
        after: Score { train_rms: rms(&train_after), held_out_rms: None },
        gain: None,
        of_explainable: of_explainable(explanation, before, after),
    };
    let out_of = |g: usize| fold_of(g, count, folds, by);
    let held: Vec<usize> = (0..count).filter(|g| out_of(*g).is_some()).collect();
    if count < 2 || held.is_empty() || rows.len() / count * (count - 1) < 2 * (after.order + 2) {
        return fit;
    }
    let predicted: Vec<Predicted> = (0..folds)
        .into_par_iter()
        .map(|fold| {
            let held: Vec<bool> = group.iter().map(|g| out_of(*g) == Some(fold)).collect();
            predict(explanation, before, after, &held)
        })
        .collect();
    // Errors of the prediction of every held-out row of the groups for which `of` holds.
    let errors = |which: fn(&Predicted) -> &Vec<f64>, of: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let row = |i: usize| {
            let fold = out_of(group[i]).filter(|_| of(group[i]))?;
            Some(rows.error[i] - which(&predicted[fold])[i])
        };
        (0..rows.len()).filter_map(row).collect()
    };
    let both = |of: &dyn Fn(usize) -> bool| (rms(&errors(|p| &p.0, of)), rms(&errors(|p| &p.1, of)));
    let (held_before, held_after) = both(&|_| true);
    fit.before.held_out_rms = Some(held_before);
    fit.after.held_out_rms = Some(held_after);
    let gains: Vec<f64> = held
        .iter()
        .map(|g| {
            let (before, after) = both(&|h| h == *g);
            before - after
        })
        .collect();
    if !after.terms.is_empty() {
        let value = mean(&gains);
        let n = gains.len() as f64;
        let deviation = (gains.iter().map(|g| (g - value).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
        let quantile = StudentsT::new(0.0, 1.0, (n - 1.0).max(1.0)).map_or(1.96, |t| t.inverse_cdf(0.975));
        let half = quantile * deviation / n.sqrt();
        fit.gain = Some(Gain { value, ci95: [value - half, value + half] });
    }
    fit
}

/// Predictions of the base alone and of the model that a search without the held-out rows finds, the orders of
/// both chosen without them as well.
fn predict(explanation: &Explanation, before: &Model, after: &Model, held: &[bool]) -> Predicted {
    let search = &explanation.search;
    let rows = search.rows;
    let mut noise: Noise = search.noise.clone();
    noise.sigma.iter_mut().zip(held).filter(|(_, h)| **h).for_each(|(s, _)| *s *= UNMEASURED);
    let again = Search::with_noise(search, noise);
    let terms = if after.terms.is_empty() { Vec::new() } else { again.run(Vec::new()) };
    let inner = Explanation { search: again, chosen: terms.len(), terms };
    let noise = &inner.search.noise;
    let value = |terms: &[Term], lowest: usize, highest: usize| -> Vec<f64> {
        // Fewer rows never justify a higher order than all of them.
        let mut raw = base_columns(rows, choose_order(&inner, terms).max(lowest).min(highest));
        raw.extend(terms.iter().flat_map(|t| t.columns.iter().cloned()));
        let whitened: Vec<Vec<f64>> = raw.iter().map(|c| noise.whiten(c)).collect();
        let solution = least_squares(&whitened, &noise.whiten(&noise.clean));
        let mut sum = vec![0.0; rows.len()];
        for (a, column) in solution.coefficients.iter().zip(&raw) {
            crate::linear::add_scaled(&mut sum, *a, column);
        }
        sum
    };
    let base = value(&[], 1, before.order);
    let with = if inner.terms.is_empty() {
        base.clone()
    } else {
        value(&inner.terms, first_order(rows), after.order)
    };
    (base, with)
}

/// Variance explained by the terms over that explained by the saturated model, each for its freedom.
fn of_explainable(explanation: &Explanation, before: &Model, after: &Model) -> Option<f64> {
    if after.terms.is_empty() {
        return None;
    }
    let search = &explanation.search;
    let rows = search.rows;
    let noise = &search.noise;
    let target = noise.whiten(&noise.clean);
    let level = |columns: &[Vec<f64>]| {
        let whitened: Vec<Vec<f64>> = columns.iter().map(|c| noise.whiten(c)).collect();
        let rank = whitened.len();
        least_squares(&whitened, &target).rss / (rows.len() as f64 - rank as f64).max(1.0)
    };
    let base = level(&base_columns(rows, before.order));
    let of = |wanted: &dyn Fn(&FittedTerm) -> bool| {
        let mut columns = base_columns(rows, after.order);
        columns.extend(after.terms.iter().filter(|t| wanted(t)).flat_map(|t| t.term.columns.iter().cloned()));
        level(&columns)
    };
    // What was located without a name is part of what can be explained, not of what the named effects explain.
    let named = of(&|t| t.effect.is_some());
    let flexible = level(&saturated(rows, &base_columns(rows, after.order))).min(of(&|_| true)).min(named);
    (base > flexible).then(|| ((base - named) / (base - flexible)).clamp(0.0, 1.0))
}
