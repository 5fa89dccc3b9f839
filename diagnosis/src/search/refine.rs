//! The shape of a candidate: tried at one value, improved beside a model by a compass search, and improved
//! again in turn beside the other terms.

use std::sync::Arc;

use numerics::{Basis, add_scaled, dot, least_squares};

use super::{Found, MOST_TIED, NEAR_TIE, Search, Term};
use crate::base::base_columns;
use crate::calibrate::log_tail;
use crate::steps::beginning;
use crate::thresholds::search::refine::{FINE, SHRUNK};

impl Search<'_> {
    /// What a shape of an effect explains beside a basis, with its scores.
    pub(super) fn try_shape(
        &self,
        family: usize,
        shape: &[f64],
        basis: &Basis,
        residual: &[f64],
    ) -> Option<Found> {
        let e = self.effect(family)?;
        if !self.over[e].possible_shape(shape) {
            return None;
        }
        let columns = self.over[e].signature(shape);
        let mut own = Basis::new(self.rows.len());
        let mut left = Vec::with_capacity(columns.len());
        let (own_columns, missing) =
            columns.split_at(self.dictionary.families[family].own.unwrap_or(columns.len()));
        let mut first_own = 0;
        for (k, column) in missing.iter().chain(own_columns).enumerate() {
            if k == missing.len() {
                first_own = own.rank();
            }
            let mut w = self.whitener.whiten(column);
            let length = dot(&w, &w).sqrt();
            basis.project_off(&mut w);
            if dot(&w, &w).sqrt() > self.dictionary.families[family].smallest_part * length {
                own.add(&w);
            }
            left.push(w);
        }
        // In the order of the columns.
        left.rotate_left(missing.len());
        if columns.len() > 1
            && self.catalogue[e].limits_amplitudes()
            && !self.catalogue[e].plausible_at(self.rows, shape, &least_squares(&left, residual).coefficients)
        {
            return None;
        }
        let scores: Vec<f64> = (0..own.rank()).map(|k| dot(own.columns.get(k), residual)).collect();
        let pays = self.pays_beside_what_is_missing(family, &scores[first_own..]);
        if scores.is_empty() || !self.possible(family, &scores) || !pays {
            return None;
        }
        let explained = dot(&scores, &scores);
        let surprise = self.calibration.families[family].surprise(log_tail(explained, scores.len()));
        Some(Found { term: Term::new(family, shape.to_vec(), Arc::new(columns)), explained, surprise })
    }

    /// Improves the shape of a candidate beside a model from every top of its grid, down to steps that are `precision` of
    /// the first ones.
    pub(super) fn refine(&self, found: Found, basis: &Basis, residual: &[f64], precision: f64) -> Found {
        let family = found.term.family;
        let rivals = Arc::clone(&found.term.rivals);
        let free = self.effect(family).and_then(|e| self.only_free_shape(e));
        let elsewhere = |value: &f64| {
            let mut shape = found.term.shape.clone();
            let here = std::mem::replace(&mut shape[free?], *value);
            if here == *value { None } else { self.try_shape(family, &shape, basis, residual) }
        };
        let others: Vec<Found> = rivals.iter().filter_map(elsewhere).collect();
        let mut tops: Vec<Found> = std::iter::once(found)
            .chain(others)
            .map(|found| self.refine_one(found, basis, residual, precision))
            .collect();
        tops.sort_by(|a, b| b.explained.total_cmp(&a.explained));
        if let Some(free) = free.filter(|_| tops.len() > 1) {
            let least = (1.0 - NEAR_TIE) * tops[0].explained;
            let tied = tops[1..].iter().take(MOST_TIED).filter(|top| top.explained >= least);
            tops[0].term.rivals = Arc::new(tied.map(|top| top.term.shape[free]).collect());
        }
        tops.swap_remove(0)
    }

    /// The same from one shape, by a compass search.
    fn refine_one(&self, found: Found, basis: &Basis, residual: &[f64], precision: f64) -> Found {
        let family = found.term.family;
        let Some(e) = self.effect(family) else { return found };
        let effect = &self.catalogue[e];
        if let Some(jumps) = self.dictionary.jumps(&self.dictionary.families[family], &self.whitener, basis) {
            return self.best_step(family, &jumps, residual).unwrap_or(found);
        }
        let mut best = found;
        if effect.shape_follows {
            return self.make_consistent(best, basis, residual);
        }
        let ranges = &self.ranges[e];
        if ranges.is_empty() {
            return best;
        }
        let mut steps = self.first_steps(family, &best.term.shape);
        let least: Vec<f64> = steps.iter().map(|s| s * precision).collect();
        for _ in 0..200 {
            let mut improved = false;
            let mut active = false;
            for k in 0..ranges.len() {
                let whole = ranges[k].whole;
                if steps[k] == 0.0 || (!whole && steps[k] < least[k]) || (whole && steps[k] < 1.0) {
                    continue;
                }
                active = true;
                let mut here = false;
                // What the shape explains on either side, as far as it was looked at.
                let mut sides = [None; 2];
                let moved = |from: &[f64], by: f64| {
                    let mut shape = from.to_vec();
                    shape[k] = if ranges[k].logarithmic { shape[k] * by.exp() } else { shape[k] + by };
                    shape[k] = shape[k].clamp(ranges[k].low, ranges[k].high);
                    (shape[k] != from[k]).then_some(shape)
                };
                for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                    let step = if whole { steps[k].round() } else { steps[k] };
                    let Some(shape) = moved(&best.term.shape, sign * step) else { continue };
                    let Some(next) = self.try_shape(family, &shape, basis, residual) else { continue };
                    *side = Some(next.explained);
                    if next.explained > best.explained {
                        best = next;
                        here = true;
                        break;
                    }
                }
                // Both sides explain less: the top of the parabola through the three is nearer than either.
                if let ([Some(up), Some(down)], false, false) = (sides, here, whole) {
                    let bend = 2.0 * best.explained - up - down;
                    if let Some(shape) =
                        moved(&best.term.shape, 0.5 * steps[k] * (up - down) / bend.max(1e-300))
                        && let Some(next) = self.try_shape(family, &shape, basis, residual)
                        && next.explained > best.explained
                    {
                        best = next;
                    }
                    steps[k] *= SHRUNK;
                    continue;
                }
                if here { improved = true } else { steps[k] *= 0.5 }
            }
            if !active && !improved {
                break;
            }
        }
        best
    }

    /// First steps of the compass: half the distance to the neighbouring starts.
    fn first_steps(&self, family: usize, shape: &[f64]) -> Vec<f64> {
        let Some(e) = self.effect(family) else { return Vec::new() };
        let ranges = &self.ranges[e];
        let candidates = &self.dictionary.candidates[self.dictionary.families[family].candidates.clone()];
        ranges
            .iter()
            .enumerate()
            .map(|(k, r)| {
                if r.high <= r.low {
                    return 0.0;
                }
                let place = |v: f64| if r.logarithmic { v.ln() } else { v };
                let here = place(shape[k]);
                let nearest = candidates
                    .iter()
                    .map(|c| (place(c.shape[k]) - here).abs())
                    .filter(|d| *d > 1e-9 * here.abs().max(1e-9))
                    .fold(f64::INFINITY, f64::min);
                let step =
                    if nearest.is_finite() { 0.5 * nearest } else { 0.1 * (place(r.high) - place(r.low)) };
                if r.whole { step.max(4.0) } else { step }
            })
            .collect()
    }

    /// Solves for a shape that is its own amplitude, from every start of the family.
    fn make_consistent(&self, found: Found, basis: &Basis, residual: &[f64]) -> Found {
        let family = found.term.family;
        let Some(e) = self.effect(family) else { return found };
        let effect = &self.catalogue[e];
        let mut best: Option<Found> = None;
        for candidate in &self.dictionary.candidates[self.dictionary.families[family].candidates.clone()] {
            let mut shape = candidate.shape.clone();
            for _ in 0..4 {
                let mut w = self.whitener.whiten(&self.over[e].signature(&shape)[0]);
                basis.project_off(&mut w);
                let amplitude = dot(&w, residual) / dot(&w, &w).max(1e-300);
                shape = effect.consistent_shape(&shape, &[amplitude], self.rows);
            }
            let next = self.try_shape(family, &shape, basis, residual);
            let worth = |found: &Found| found.explained - effect.reluctance(&found.term.shape);
            best = match (best, next) {
                (Some(best), Some(next)) if worth(&next) <= worth(&best) => Some(best),
                (best, next) => next.or(best),
            };
        }
        best.unwrap_or(found)
    }

    /// Moves steps to the row at which the raw observations have them. To the cleaned ones a row on the wrong
    /// side of a large step is an outlier, which was pulled in, so that the step stays where it was first put.
    pub fn relocate(&self, terms: &mut [Term]) {
        for index in 0..terms.len() {
            let Some(e) = self.effect(terms[index].family) else { continue };
            let effect = &self.catalogue[e];
            if !effect.begins_at_a_row {
                continue;
            }
            let mut columns = base_columns(self.rows, self.base_order);
            let first_column = columns.len() + terms[..index].iter().map(|t| t.columns.len()).sum::<usize>();
            columns.extend(terms.iter().flat_map(|t| t.columns.iter().cloned()));
            let white: Vec<Vec<f64>> = columns.iter().map(|c| self.whitener.whiten(c)).collect();
            let solution = least_squares(&white, &self.whitener.whiten(&self.noise.clean));
            let mut left = self.rows.error.clone();
            for (a, column) in solution.coefficients.iter().zip(&columns) {
                add_scaled(&mut left, -a, column);
            }
            let height = solution.coefficients[first_column];
            // Without the step.
            add_scaled(&mut left, height, &terms[index].columns[0]);
            let here = terms[index].shape[0] as usize;
            let row = beginning(&left, &self.noise, height, here, &self.rows.t_s);
            if row != here {
                let shape = vec![row as f64];
                let columns = self.over[e].signature(&shape);
                terms[index] = Term::new(terms[index].family, shape, Arc::new(columns));
            }
        }
    }

    /// Refines every term in turn beside the others, and tries richer forms.
    pub fn backfit(&self, terms: &mut [Term]) {
        if let Some(shapes) = self.backfitted(terms) {
            for (term, (shape, rivals)) in terms.iter_mut().zip(shapes) {
                term.rivals = rivals;
                if let Some(e) = self.effect(term.family).filter(|_| term.shape != shape) {
                    (term.columns, term.shape) = (Arc::new(self.over[e].signature(&shape)), shape);
                }
            }
            return;
        }
        let before = terms.to_vec();
        self.backfit_anew(terms);
        self.keep_backfitted(&before, terms);
    }

    fn backfit_anew(&self, terms: &mut [Term]) {
        for sweep in 0..2 {
            for k in 0..terms.len() {
                let Some(e) = self.effect(terms[k].family) else { continue };
                if self.ranges[e].is_empty() || (terms.len() == 1 && sweep > 0) {
                    continue;
                }
                let others: Vec<Term> =
                    terms.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, t)| t.clone()).collect();
                let (basis, residual) = self.fit(&others);
                let Some(mut start) = self.try_shape(terms[k].family, &terms[k].shape, &basis, &residual)
                else {
                    continue;
                };
                start.term.rivals = Arc::clone(&terms[k].rivals);
                let mut best = self.refine(start, &basis, &residual, FINE);
                let plain = best.term.shape.clone();
                while let Some(shape) = self.over[e].richer(&best.term.shape) {
                    let Some(richer) = self.try_shape(best.term.family, &shape, &basis, &residual) else {
                        break;
                    };
                    // A further harmonic: two more columns, at the level of one test in some hundred.
                    if richer.explained - best.explained < 2.0 * 5.3 {
                        break;
                    }
                    let rivals = Arc::clone(&best.term.rivals);
                    best = Found { term: Term { rivals, ..richer.term }, ..richer };
                }
                // The shape hardly moves with its richness: once refined again at the end is enough.
                if best.term.shape != plain {
                    best = self.refine(best, &basis, &residual, FINE);
                }
                terms[k] = best.term;
            }
        }
    }
}
