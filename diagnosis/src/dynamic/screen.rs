//! The linearised score test: what every candidate would explain beside the present model, to first order,
//! from one free-run simulation with the candidates' sensitivities at zero amount. Residual and
//! sensitivities are whitened by the residual's own autoregression, and the present model's parameters and
//! initial states are free beside each candidate.

use numerics::parallel;

use super::data::{CHOOSE_ROWS, Data, FIT_ROWS, Folds};
use super::estimate::Fitted;
use super::gram::Grams;
use super::search::Augmented;
use crate::thresholds::dynamic::gram::MOST_FREE;
use crate::thresholds::dynamic::model::MOST_PROBED;

/// −2 log likelihood that every candidate beside a model gains on the rows that fit, by its number, residual and
/// sensitivities passed through each of the filters; those that cannot be screened are left out.
pub fn screen<M: Augmented, const F: usize>(
    present: &Fitted<M>,
    candidates: &[M::Term],
    data: &Data,
    filters: [&[f64]; F],
) -> [Vec<(usize, f64)>; F] {
    let base = present.model.packed().len();
    // Packs of candidates that fit into one simulation.
    let mut packs: Vec<Vec<usize>> = Vec::new();
    let (mut lanes, mut extra) = (usize::MAX, 0);
    for (k, candidate) in candidates.iter().enumerate() {
        let (own, needs) = (M::amounts(candidate), M::states(candidate));
        if own == 0 || base + own > MOST_FREE {
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
    let of = |pack: &[usize]| screen_pack(present, candidates, pack, data, filters);
    // One that cannot be simulated does not take the others of its pack with it.
    let of_pack = |pack: &Vec<usize>| match of(pack) {
        Some(all) => vec![all],
        None => pack.chunks(1).filter_map(of).collect(),
    };
    let screened = parallel::map(&packs, of_pack);
    let mut all = filters.map(|_| Vec::new());
    for pack in screened.into_iter().flatten() {
        all.iter_mut().zip(pack).for_each(|(all, some)| all.extend(some));
    }
    all
}

fn screen_pack<M: Augmented, const F: usize>(
    present: &Fitted<M>,
    candidates: &[M::Term],
    pack: &[usize],
    data: &Data,
    filters: [&[f64]; F],
) -> Option<[Vec<(usize, f64)>; F]> {
    let base = present.model.packed().len();
    let with = |model: M, k: &usize| model.with(M::probed(&candidates[*k]));
    let model = pack.iter().try_fold(present.model.clone(), with)?;
    let through = model.normals(&present.states, data, filters).ok()?;
    Some(through.map(|whole| {
        let mut first = base;
        pack.iter()
            .map(|k| {
                let own = M::amounts(&candidates[*k]);
                let lanes: Vec<usize> = (0..base).chain(first..first + own).collect();
                first += own;
                (*k, gained(&whole, base, &lanes).0)
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
