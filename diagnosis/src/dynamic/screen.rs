//! The linearised score test: what every candidate would explain beside the present model, to first order,
//! from one free-run simulation with the candidates' sensitivities at zero amount. Residual and
//! sensitivities are whitened by the residual's own autoregression, and the present model's parameters and
//! initial states are free beside each candidate.

use rayon::prelude::*;

use super::data::{CHOOSE_ROWS, Data, FIT_ROWS, Folds};
use super::effects::Part;
use super::estimate::Fitted;
use super::gram::{Grams, grams_through};
use super::model::{Model, Term};
use crate::thresholds::dynamic::gram::MOST_FREE;
use crate::thresholds::dynamic::model::MOST_PROBED;

/// Whether a term can be screened: its amounts are zero and its shapes given.
pub fn linear(term: &Term) -> bool {
    let amounts = || term.effect.parameters.iter().zip(&term.parameters).filter(|(p, _)| !p.shape);
    amounts().count() > 0 && amounts().all(|(_, v)| *v == 0.0)
}

/// The term as it is screened: only its amounts are free.
fn probed(term: &Term) -> Term {
    let free = term.effect.parameters.iter().map(|p| !p.shape).collect();
    Term { free, probe: term.effect.part == Part::Force, ..term.clone() }
}

/// What a candidate promises.
#[derive(Clone)]
pub struct Screened {
    /// Index of the candidate.
    pub candidate: usize,
    /// −2 log likelihood gained on the rows that fit.
    pub gain: f64,
}

/// Screens candidates beside a model, residual and sensitivities passed through each of the filters; those that
/// cannot be screened are left out.
pub fn screen<const F: usize>(
    present: &Fitted,
    candidates: &[Term],
    data: &Data,
    filters: [&[f64]; F],
) -> [Vec<Screened>; F] {
    let base = present.model.free();
    // Packs of candidates that fit into one simulation.
    let mut packs: Vec<Vec<usize>> = Vec::new();
    let (mut lanes, mut extra) = (usize::MAX, 0);
    for (k, candidate) in candidates.iter().enumerate().filter(|(_, c)| linear(c)) {
        let own = candidate.effect.parameters.iter().filter(|p| !p.shape).count();
        let needs = candidate.effect.states;
        if base + own > MOST_FREE {
            continue;
        }
        let full = lanes == usize::MAX || lanes + own > MOST_FREE || extra + needs > MOST_PROBED;
        match packs.last_mut() {
            Some(pack) if !full => pack.push(k),
            _ => {
                packs.push(vec![k]);
                (lanes, extra) = (base, 0);
            }
        }
        lanes += own;
        extra += needs;
    }
    let screened: Vec<[Vec<Screened>; F]> =
        packs.par_iter().filter_map(|pack| screen_pack(present, candidates, pack, data, filters)).collect();
    let mut all = filters.map(|_| Vec::new());
    for pack in screened {
        all.iter_mut().zip(pack).for_each(|(all, some)| all.extend(some));
    }
    all
}

fn screen_pack<const F: usize>(
    present: &Fitted,
    candidates: &[Term],
    pack: &[usize],
    data: &Data,
    filters: [&[f64]; F],
) -> Option<[Vec<Screened>; F]> {
    let base = present.model.free();
    let with = |members: &[usize]| -> Model {
        members.iter().fold(present.model.clone(), |model, k| model.with(probed(&candidates[*k])))
    };
    let through = grams_through(&with(pack), &present.states, data, filters).ok()?;
    Some(through.map(|whole| {
        let mut first = base;
        pack.iter()
            .map(|k| {
                let own = candidates[*k].effect.parameters.iter().filter(|p| !p.shape).count();
                let lanes: Vec<usize> = (0..base).chain(first..first + own).collect();
                first += own;
                Screened { candidate: *k, gain: gained(&whole, base, &lanes).0 }
            })
            .collect()
    }))
}

/// −2 log likelihood that the directions of `lanes` gain over the first `base`: where they are fitted, and
/// on the rows that choose.
pub fn gained(whole: &Grams, base: usize, lanes: &[usize]) -> (f64, f64) {
    let common: Vec<usize> = (0..base).collect();
    let before = solved(whole, &common, FIT_ROWS, CHOOSE_ROWS);
    let after = solved(whole, lanes, FIT_ROWS, CHOOSE_ROWS);
    let gain = |rows: usize, a: f64, b: f64| {
        let ratio = a.max(f64::MIN_POSITIVE) / b.max(f64::MIN_POSITIVE);
        rows as f64 * ratio.ln()
    };
    (gain(whole.rows(FIT_ROWS), before.0, after.0), gain(whole.rows(CHOOSE_ROWS), before.1, after.1))
}

/// Least squares in some directions on some rows: what is left there, and what is left on others.
fn solved(whole: &Grams, lanes: &[usize], on: Folds, other: Folds) -> (f64, f64) {
    let reduced = whole.reduced(on, 0.0, &[]);
    let last = reduced.size - 1;
    let right: Vec<f64> = lanes.iter().map(|a| reduced.at(*a, last)).collect();
    let step = reduced.part(lanes.iter().copied()).factor().solve(&right);
    let explained: f64 = step.iter().zip(&right).map(|(x, r)| x * r).sum();
    // On the other rows with the same step, the initial states as fitted.
    let mut left = 0.0;
    for run in 0..whole.products.len() {
        let here = whole.of_run(run, on);
        let there = whole.of_run(run, other);
        let end = here.size - 1;
        let mut along = vec![0.0; last];
        lanes.iter().zip(&step).for_each(|(lane, step)| along[*lane] = *step);
        let full = whole.with_state(&here, &along, 0.0);
        left += there.at(end, end);
        for i in 0..end {
            left -= 2.0 * full[i] * there.at(i, end);
            left += (0..end).map(|j| full[i] * there.at(i, j) * full[j]).sum::<f64>();
        }
    }
    (reduced.at(last, last) - explained, left)
}
