//! From rows to the set of terms that explains them, and the search that found it: noise about a saturated
//! model first, then, once something is found, noise about what was found and the search again.

use std::sync::Arc;

use numerics::{Basis, dot, least_squares, rms};

use crate::ambiguity::contained;
use crate::base::base_columns;
use crate::dictionary::highest_order;
use crate::effects::Effect;
use crate::generic::{saturated, scaled, slow_structure, times};
use crate::noise::{Noise, estimate_white, estimate_with};
use crate::rows::Rows;
use crate::search::{self, Search, Term};
use crate::thresholds::explain::{
    ANY_WILL_DO, CHARACTERISTIC, GROSS, LONGEST_MEMORY, MISFIT_OF_A_CURVE, MOSTLY, NEARLY, SAME_CORRELATION,
    STAGE_GAIN, STAGES, UNMEASURED,
};
use crate::thresholds::intervals::DETERMINED;
use crate::thresholds::verdict::ALTERNATIVE_MARGIN;

/// Order of the base polynomial that is absorbed before anything is tested: the paper's for a pair, a
/// straight line for a sensor that reports the angle itself (its polynomial must extrapolate).
pub fn first_order(rows: &Rows) -> usize {
    if let Some(order) = rows.order {
        return order;
    }
    let wanted = if rows.pair { 9 } else { 1 };
    wanted.min(highest_order(rows))
}

/// What was found.
pub struct Explanation<'a> {
    /// The search with its final noise and calibration.
    pub search: Search<'a>,
    /// The terms, refined.
    pub terms: Vec<Term>,
    /// How many of them the search chose; one more may stand for what the names leave.
    pub chosen: usize,
    /// Standard deviation of a row's noise, outliers included: the floor.
    pub floor: f64,
    /// Whether the mismatch is many times the noise, so that the effects were found one by one and structure may be
    /// left.
    pub gross: bool,
}

impl Explanation<'_> {
    /// The further orders of the base that were found.
    pub fn orders(&self) -> impl Iterator<Item = &Term> {
        self.terms.iter().filter(|term| self.search.is_order(term.family))
    }
}

/// What the noise's variance may depend on.
pub(crate) fn covariates(rows: &Rows) -> Vec<Vec<f64>> {
    let x = rows.scaled_reading();
    let centre = |v: Vec<f64>| numerics::centred(&v);
    let mut out = vec![
        centre(times(&x, &x)),
        centre(x.iter().map(|x| x.abs()).collect()),
        centre(x.clone()),
        centre(scaled(&rows.t_s)),
    ];
    if let Some(t) = &rows.temperature_c {
        out.push(centre(scaled(t)));
    }
    out
}

/// An explanation, and the noise floor about the saturated model where the mismatch is gross beside it.
pub struct Found<'a> {
    /// The explanation.
    pub explanation: Explanation<'a>,
    /// The floor; none where the mismatch is not gross.
    pub gross: Option<f64>,
}

/// What every explanation of a recording starts from, whatever the effects.
pub struct Outset {
    order: usize,
    base: Vec<Vec<f64>>,
    covariates: Vec<Vec<f64>>,
    slow: Vec<Vec<Vec<f64>>>,
    /// The noise about the saturated model.
    noise: Noise,
}

impl Outset {
    /// Correlation of neighbouring readings about the saturated model.
    pub fn correlation(&self) -> f64 {
        self.noise.correlation.typical()
    }

    /// How much more likely a column beside a model's makes observations, in −2 log likelihood, noise being whatever suits either
    /// best.
    pub fn gain(&self, observed: &[f64], model: &[Vec<f64>], column: &[f64]) -> f64 {
        let noise = &self.noise;
        noise.correlation.gain(observed, model, &noise.sigma, &[column.to_vec()])
    }

    /// Estimates the noise of a recording of which nothing is known yet.
    pub fn of(rows: &Rows) -> Outset {
        let order = first_order(rows);
        let base = base_columns(rows, order);
        let covariates = covariates(rows);
        let slow = slow_structure(rows);
        let noise = estimate_with(
            &rows.error,
            &rows.t_s,
            &saturated(rows, &base),
            &base,
            &covariates,
            &slow,
            rows.sort(),
        );
        Outset { order, base, covariates, slow, noise }
    }
}

/// Explains a recording. `skip` leaves effects out of the catalogue by id.
pub fn explain<'a>(rows: &'a Rows, outset: &Outset, catalogue: &'a [Effect], skip: &[String]) -> Found<'a> {
    let Outset { order, base, covariates, slow, noise } = outset;
    let order = *order;
    let floor = noise.as_read;
    // What a curved characteristic leaves of a straight line is no mismatch.
    let curved = base_columns(rows, order.max(CHARACTERISTIC.min(highest_order(rows))));
    let gross = Some(floor).filter(|floor| left_by(&curved, &rows.error, None) > GROSS * floor);
    let search = Search::new(rows, catalogue, order, noise.clone(), skip);
    if !strongest(&search).is_some_and(|found| search.significant(&found)) {
        let explanation = Explanation { search, terms: Vec::new(), chosen: 0, floor, gross: false };
        return Found { explanation, gross };
    }
    let mut terms = search.reshuffle(search.run(Vec::new()));
    let mut last: Option<Search> = None;
    // Noise about what was found: nothing of it is left in the floor, and less freedom is spent.
    for _ in 0..2 {
        let now = last.as_ref().unwrap_or(&search);
        // Of a single move nothing repeats: what is left of its shape beside a named effect may as well be noise
        // that is correlated, and only what exceeds that is structure.
        if rows.single_move() && terms.iter().any(|t| now.effect(t.family).is_some()) {
            terms.retain(|t| now.effect(t.family).is_some());
        }
        now.relocate(&mut terms);
        let mut model = base.clone();
        model.extend(terms.iter().flat_map(|t| t.columns.iter().cloned()));
        let light = model.clone();
        // What the names leave would be taken for memory. (Of a single move it may well be that.)
        let is_form = |t: &Term| now.effect(t.family).is_some_and(|e| catalogue[e].is_form());
        let unexplained = terms.iter().any(|t| now.is_generic(t.family) || is_form(t))
            || (!rows.single_move() && search.leaves_much(&terms));
        if unexplained {
            let all = saturated(rows, base);
            model.extend(all.into_iter().skip(base.len()));
        }
        let noise = estimate_with(&rows.error, &rows.t_s, &model, &light, covariates, slow, rows.sort());
        // The tails depend on the design and the correlation, not on the level: only where the correlation is
        // another one are they resampled.
        let again =
            if (noise.correlation.typical() - now.noise.correlation.typical()).abs() < SAME_CORRELATION {
                Search::with_noise(now, noise)
            } else {
                Search::again(now, noise)
            };
        let next = again.reshuffle(again.run(terms.clone()));
        let same = next.len() == terms.len() && next.iter().zip(&terms).all(|(a, b)| a.family == b.family);
        last = Some(again);
        terms = next;
        if same {
            break;
        }
    }
    drop_what_a_curve_leaves(last.as_ref().unwrap_or(&search), &mut terms);
    // The noise about the saturated model has no part in whatever the names leave, and judges it.
    let chosen = terms.len();
    let named = terms.iter().any(|t| search.effect(t.family).is_some());
    let rest = match named && !terms.iter().any(|t| search.is_generic(t.family)) {
        true => search.modulation(&terms).or_else(|| search.remainder(&terms).map(|rest| rest.term)),
        false => None,
    };
    let about = last.as_ref().unwrap_or(&search);
    let mut floor = about.noise.as_read;
    if let Some(rest) = rest.and_then(|rest| beyond_names(rest, base, &terms)) {
        terms.push(rest);
        // What is found is no noise.
        let model = columns_with(base, &terms);
        let noise = estimate_with(&rows.error, &rows.t_s, &model, &model, covariates, slow, rows.sort());
        floor = floor.min(noise.as_read);
    }
    let search = last.unwrap_or(search);
    Found { explanation: Explanation { search, terms, chosen, floor, gross: false }, gross }
}

/// The structure that the named effects leave. If its columns can make up one of a named effect, nothing of that effect would be
/// determined beside it: then only their part outside the named effects is kept, and nothing where there is none.
fn beyond_names(rest: Term, base: &[Vec<f64>], names: &[Term]) -> Option<Term> {
    let whole = columns_with(base, std::slice::from_ref(&rest));
    if !names.iter().flat_map(|name| name.columns.iter()).any(|column| contained(column, &whole)) {
        return Some(rest);
    }
    let mut said = Basis::new(base[0].len());
    for column in columns_with(base, names) {
        said.add(&column);
    }
    let beyond = |column: &Vec<f64>| {
        let mut left = column.clone();
        said.project_off(&mut left);
        (rms(&left) > DETERMINED * rms(column)).then_some(left)
    };
    let columns: Vec<Vec<f64>> = rest.columns.iter().filter_map(beyond).collect();
    (!columns.is_empty()).then(|| Term { columns: Arc::new(columns), ..rest })
}

/// The terms with the strongest significant effect more; of those that do nearly as well one that a correction can undo,
/// and then the simplest, since what the others do better is a part of what is left. What is easily taken for an effect
/// that is there already would describe it twice.
fn simplest(search: &Search, terms: &[Term]) -> Option<Vec<Term>> {
    let effect_of = |f: usize| search.effect(f).map(|e| &search.catalogue[e]);
    let taken: Vec<&String> =
        terms.iter().filter_map(|t| effect_of(t.family)).flat_map(|e| &e.confused_with).collect();
    let named = |f: usize| effect_of(f).is_some_and(|e| !taken.contains(&&e.id));
    let mut found = search.contenders_refined(terms, named, usize::MAX, f64::NEG_INFINITY);
    found.retain(|f| search.significant(f));
    let best = search.gain(found.first()?);
    let margin = ALTERNATIVE_MARGIN.max(NEARLY * search.rows.len() as f64);
    let effect = |f: &&search::Found| search.effect(f.term.family).map(|e| (e, &search.catalogue[e]));
    let rank = |f: &&search::Found| effect(f).map(|(e, effect)| (effect.of_one_time, search.free_shapes(e)));
    let near = found.iter().filter(|f| search.gain(f) > best - margin);
    let mut next = terms.to_vec();
    next.push(near.min_by_key(rank)?.term.clone());
    search.backfit(&mut next);
    Some(next)
}

/// Root mean square of what columns leave of the errors of the rows that are not held out.
fn left_by(columns: &[Vec<f64>], error: &[f64], held: Option<&[bool]>) -> f64 {
    let taken = |v: &[f64]| -> Vec<f64> {
        v.iter().enumerate().filter(|(i, _)| held.is_none_or(|held| !held[*i])).map(|(_, v)| *v).collect()
    };
    let error = taken(error);
    let columns: Vec<Vec<f64>> = columns.iter().map(|column| taken(column)).collect();
    (least_squares(&columns, &error).rss / error.len().max(1) as f64).sqrt()
}

/// The base's columns and the terms'.
fn columns_with(base: &[Vec<f64>], terms: &[Term]) -> Vec<Vec<f64>> {
    base.iter().chain(terms.iter().flat_map(|t| t.columns.iter())).cloned().collect()
}

/// The strongest effects one by one, by rows that are not held out: what is not yet explained counts as noise without a
/// memory, as strong as it is, and each effect brings it down. With what they leave, and the base alone.
fn stages(
    search: &Search,
    base: &[Vec<f64>],
    start: Vec<Term>,
    held: Option<&[bool]>,
) -> (Vec<Term>, f64, f64) {
    let rows = search.rows;
    let covariates = covariates(rows);
    let before = left_by(base, &rows.error, held);
    let mut left = left_by(&columns_with(base, &start), &rows.error, held);
    let mut terms = start;
    for _ in 0..STAGES {
        let mut noise = estimate_white(&rows.error, &rows.t_s, &columns_with(base, &terms), &covariates);
        let unmeasured = |(sigma, held): (&mut f64, &bool)| *sigma *= if *held { UNMEASURED } else { 1.0 };
        noise.sigma.iter_mut().zip(held.unwrap_or_default()).for_each(unmeasured);
        let Some(next) = simplest(&Search::with_noise(search, noise), &terms) else { break };
        let now = left_by(&columns_with(base, &next), &rows.error, held);
        if now > STAGE_GAIN * left {
            break;
        }
        (terms, left) = (next, now);
    }
    (terms, left, before)
}

/// What `fit` already found of a sensor that turns, as terms.
fn found_by_fit(search: &Search) -> Vec<Term> {
    let Some(turn) = &search.rows.turn else { return Vec::new() };
    let found = |f: &usize| search.effect(*f).is_some_and(|e| search.catalogue[e].found_by_fit(turn));
    (0..search.dictionary.families.len())
        .filter(found)
        .map(|family| {
            let candidate =
                &search.dictionary.candidates[search.dictionary.families[family].candidates.start];
            Term::new(family, candidate.shape.clone(), Arc::clone(&candidate.columns))
        })
        .collect()
}

/// Explains a mismatch many times the noise. Beside it the saturated model is no model any more: what it leaves is
/// structure, which would be taken for noise with a memory and whiten the mismatch away. So the strongest effects are
/// found one by one, and fitted with every row alike. None where they do not explain most of the mismatch.
pub fn explain_gross<'a>(
    rows: &'a Rows,
    outset: &Outset,
    catalogue: &'a [Effect],
    skip: &[String],
    floor: f64,
) -> Option<Explanation<'a>> {
    let Outset { order, base, covariates, .. } = outset;
    let noise = estimate_white(&rows.error, &rows.t_s, base, covariates);
    let search = Search::new(rows, catalogue, *order, noise, skip);
    let (terms, left, before) = stages(&search, base, found_by_fit(&search), None);
    if left > MOSTLY * before {
        return None;
    }
    let mut noise = estimate_white(&rows.error, &rows.t_s, &columns_with(base, &terms), covariates);
    // Neighbouring rows repeat each other: so many fewer of them count.
    let whitened = &noise.whitened_residual;
    let lagged: f64 = whitened.windows(2).map(|w| w[0] * w[1]).sum();
    let typical = (lagged / dot(whitened, whitened).max(1e-300)).clamp(0.0, LONGEST_MEMORY);
    let spread = ((1.0 + typical) / (1.0 - typical)).sqrt();
    noise.sigma.iter_mut().for_each(|sigma| *sigma *= spread);
    let search = Search::with_noise(&search, noise);
    let chosen = terms.len();
    Some(Explanation { search, terms, chosen, floor, gross: true })
}

/// The same search where some rows are held out, nothing found yet.
pub fn without_held<'a>(whole: &Explanation<'a>, held: &[bool]) -> Explanation<'a> {
    let mut noise = whole.search.noise.clone();
    noise.sigma.iter_mut().zip(held).filter(|(_, h)| **h).for_each(|(s, _)| *s *= UNMEASURED);
    let search = Search::with_noise(&whole.search, noise);
    Explanation { search, terms: Vec::new(), chosen: 0, floor: whole.floor, gross: whole.gross }
}

/// What such a search finds in the other rows.
pub fn found_without(inner: &Explanation, held: &[bool]) -> Vec<Term> {
    let search = &inner.search;
    if !inner.gross {
        return search.run(Vec::new());
    }
    let base = base_columns(search.rows, first_order(search.rows));
    stages(search, &base, found_by_fit(search), Some(held)).0
}

/// Drops names for the rest that a curve leaves of what it stands for: an effect beside structure without a name
/// is believed only where it explains more than the curve's own misfit may amount to, and where not any effect
/// would do as well.
fn drop_what_a_curve_leaves(search: &Search, terms: &mut Vec<Term>) {
    let is_curve = |t: &Term| search.is_generic(t.family);
    if !terms.iter().any(is_curve) {
        return;
    }
    let whole = search.explained(terms);
    let others = |k: usize| {
        let mut others = terms.clone();
        others.remove(k);
        others
    };
    let own: Vec<f64> = (0..terms.len()).map(|k| whole - search.explained(&others(k))).collect();
    let curves: f64 = terms.iter().zip(&own).filter(|(t, _)| is_curve(t)).map(|(_, own)| own).sum();
    let mut kept = (0..terms.len())
        .map(|k| {
            let family = terms[k].family;
            let rival = |f: usize| f != family && search.effect(f).is_some();
            let as_good = |found: &search::Found| found.explained > own[k] - ALTERNATIVE_MARGIN;
            let rivals = || search.contenders(&others(k), rival).into_iter().filter(as_good).count();
            search.effect(family).is_none() || own[k] >= MISFIT_OF_A_CURVE * curves && rivals() < ANY_WILL_DO
        })
        .collect::<Vec<bool>>()
        .into_iter();
    terms.retain(|_| kept.next() == Some(true));
}

/// The family with the smallest p-value beside the base alone.
fn strongest(search: &Search) -> Option<search::Found> {
    search
        .survey()
        .into_iter()
        .filter(|f| search.effect(f.term.family).is_some() || search.is_generic(f.term.family))
        .max_by(|a, b| search.family_wise(a).total_cmp(&search.family_wise(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_names_leave_takes_nothing_from_them() {
        let column = |of: fn(f64) -> f64| (0..50).map(|k| of(f64::from(k) / 50.0)).collect::<Vec<f64>>();
        let term = |columns: &[Vec<f64>]| Term::new(0, Vec::new(), Arc::new(columns.to_vec()));
        let (one, line, square, wave) =
            (column(|_| 1.0), column(|z| z - 0.3), column(|z| z * z), column(|z| (9.0 * z).sin()));
        let base = [one.clone()];
        let name = term(std::slice::from_ref(&line));
        let beyond = |columns: &[Vec<f64>]| {
            let rest = beyond_names(term(columns), &base, std::slice::from_ref(&name))?;
            Some(rest.columns.to_vec())
        };
        let apart = [square.clone(), wave];
        assert_eq!(beyond(&apart).as_deref(), Some(&apart[..]), "it could not take the place of the name");
        let whole = [column(|z| 2.0 * z), square];
        let left = beyond(&whole).expect("the square is left");
        assert_eq!(left.len(), 1);
        for said in [&one, &line] {
            assert!(dot(&left[0], said).abs() < 1e-12);
        }
        assert!(beyond(&whole[..1]).is_none(), "all of it is said");
    }
}
