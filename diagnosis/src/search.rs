//! The search for the set of explanations that accounts for a recording: forward, with exchange and
//! backward steps, every candidate judged jointly with the others after projecting off what the base model
//! absorbs. A set's merit is what it explains of the whitened sum of squares less a price per term, and the
//! price is what the strongest of the family's candidates explains in one recording of nothing in
//! `FALSE_ALARMS`⁻¹: no i.i.d. information criterion.

mod beside;
mod refine;
mod remainder;
mod select;

use std::sync::{Arc, OnceLock};

use numerics::{Basis, Columns, add_scaled, dot, least_squares, parallel};

use crate::base::base_columns;
use crate::calibrate::{Calibration, calibrate, log_tail};
use crate::correlation::Whitener;
use crate::dictionary::{Dictionary, Kind, Projected, Scratch};
use crate::effects::{Effect, Over, Range};
use crate::generic::observables;
use crate::jumps::Jumps;
use crate::noise::Noise;
use crate::rows::Rows;
use crate::thresholds::calibrate::GENERIC_SHARE;
use crate::thresholds::compose::{CURVE, HANDICAP, HANDICAP_PER_FACTOR};
use crate::thresholds::search::{
    GENERIC_HANDICAP, GRID_LOSS, HANDICAP_PER_COLUMN, MOST_RIVALS, MOST_TIED, NEAR_TIE, SHAPE_PRICE, TOP_LOSS,
};

/// One term of a model.
#[derive(Debug, Clone)]
pub struct Term {
    /// Its family in the dictionary.
    pub family: usize,
    /// Its shape parameters.
    pub shape: Vec<f64>,
    /// Its raw columns: shared, since sets of terms are put together and taken apart all the time.
    pub columns: Arc<Vec<Vec<f64>>>,
    /// Its one free shape parameter at the tops of the grid, where there are several: refined, any may come out highest.
    pub rivals: Arc<Vec<f64>>,
}

impl Term {
    /// A term whose shape has no rivals.
    pub fn new(family: usize, shape: Vec<f64>, columns: Arc<Vec<Vec<f64>>>) -> Term {
        Term { family, shape, columns, rivals: Arc::default() }
    }
}

/// A candidate as it stands beside a model.
#[derive(Debug, Clone)]
pub struct Found {
    /// The term it would be.
    pub term: Term,
    /// What it explains beyond the model.
    pub explained: f64,
    /// −ln of its family's p-value.
    pub surprise: f64,
}

/// Everything that a search of one recording needs.
pub struct Search<'a> {
    /// The recording.
    pub rows: &'a Rows,
    /// The catalogue.
    pub catalogue: &'a [Effect],
    /// The same over the rows.
    over: Arc<Vec<Over<'a>>>,
    /// The candidates.
    pub dictionary: Arc<Dictionary>,
    /// The noise used for whitening.
    pub noise: Noise,
    /// What makes it white.
    pub whitener: Whitener,
    /// The calibration of the whole search.
    pub calibration: Calibration,
    /// Share of the false alarms per family.
    pub shares: Vec<f64>,
    /// Price of a term by family and rank.
    prices: Vec<Vec<f64>>,
    /// Ranges of the shape parameters of every effect of the catalogue.
    ranges: Vec<Vec<Range>>,
    base_order: usize,
    /// For every effect that is a form without a name: how many further columns it reads.
    columns_of_forms: Vec<Option<usize>>,
    /// Whether there are such effects.
    with_forms: bool,
    /// What the choice of one column among all is worth, in −2 log likelihood.
    choice_of_column: f64,
    /// The candidates beside the base, made when they are first asked for.
    projected: OnceLock<Projected>,
    base: Basis,
    /// Whitened cleaned observations less the base.
    target: Vec<f64>,
    /// What was looked at already.
    kept: beside::Kept,
}

impl<'a> Search<'a> {
    /// Prepares the search: whitens, projects, calibrates.
    pub fn new(
        rows: &'a Rows,
        catalogue: &'a [Effect],
        order: usize,
        noise: Noise,
        skip: &[String],
    ) -> Search<'a> {
        let dictionary = Arc::new(Dictionary::new(rows, catalogue, order, skip));
        let over = Arc::new(catalogue.iter().map(|effect| effect.over(rows)).collect());
        Search::calibrated(rows, catalogue, order, noise, (dictionary, over))
    }

    /// The same search with another noise, calibrated anew.
    pub fn again(whole: &Search<'a>, noise: Noise) -> Search<'a> {
        let known = (Arc::clone(&whole.dictionary), Arc::clone(&whole.over));
        Search::calibrated(whole.rows, whole.catalogue, whole.base_order, noise, known)
    }

    fn calibrated(
        rows: &'a Rows,
        catalogue: &'a [Effect],
        order: usize,
        noise: Noise,
        (dictionary, over): (Arc<Dictionary>, Arc<Vec<Over<'a>>>),
    ) -> Search<'a> {
        let (base, target) = base_and_target(rows, order, &noise);
        let shares: Vec<f64> = dictionary
            .families
            .iter()
            .map(|f| match f.kind {
                Kind::Generic(_) => GENERIC_SHARE,
                Kind::Effect(e) if catalogue[e].is_form() => GENERIC_SHARE,
                Kind::Effect(_) | Kind::Order => 1.0,
            })
            .collect();
        let whitener = noise.whitener();
        let projected = dictionary.project(&whitener, &base);
        // The order of the base is no mismatch: it takes no part in the alarm.
        let alarm: Vec<f64> = dictionary
            .families
            .iter()
            .zip(&shares)
            .map(|(f, s)| if matches!(f.kind, Kind::Order) { 0.0 } else { *s })
            .collect();
        let calibration = calibrate(&dictionary, &projected, catalogue, &base, &noise, &rows.reading, &alarm);
        let prices = (0..shares.len())
            .map(|f| {
                let widths = dictionary.candidates[dictionary.families[f].candidates.clone()]
                    .iter()
                    .map(|c| c.columns.len());
                let widest = widths.max().unwrap_or(1);
                (0..=widest).map(|rank| calibration.price(f, shares[f], rank)).collect()
            })
            .collect();
        Search {
            rows,
            catalogue,
            over,
            dictionary,
            noise,
            whitener,
            calibration,
            shares,
            prices,
            ranges: catalogue.iter().map(|effect| effect.ranges(rows)).collect(),
            base_order: order,
            with_forms: catalogue.iter().any(Effect::is_form),
            columns_of_forms: catalogue
                .iter()
                .map(|effect| effect.is_form().then(|| effect.further_columns().len()))
                .collect(),
            choice_of_column: 2.0 * (observables(rows).len().max(1) as f64).ln(),
            projected: OnceLock::from(projected),
            base,
            target,
            kept: beside::Kept::default(),
        }
    }

    /// The same search with another noise (rows that count as unmeasured), its calibration kept.
    pub fn with_noise(whole: &Search<'a>, noise: Noise) -> Search<'a> {
        let order = whole.base_order;
        let dictionary = Arc::clone(&whole.dictionary);
        let (base, target) = base_and_target(whole.rows, order, &noise);
        Search {
            rows: whole.rows,
            catalogue: whole.catalogue,
            over: Arc::clone(&whole.over),
            dictionary,
            whitener: noise.whitener(),
            noise,
            calibration: whole.calibration.clone(),
            shares: whole.shares.clone(),
            prices: whole.prices.clone(),
            ranges: whole.ranges.clone(),
            base_order: order,
            with_forms: whole.with_forms,
            columns_of_forms: whole.columns_of_forms.clone(),
            choice_of_column: whole.choice_of_column,
            projected: OnceLock::new(),
            base,
            target,
            kept: beside::Kept::default(),
        }
    }

    /// The candidates beside the base.
    fn projected(&self) -> &Projected {
        self.projected.get_or_init(|| self.dictionary.project(&self.whitener, &self.base))
    }

    /// Whether the term is a catalogued effect, and which.
    pub fn effect(&self, family: usize) -> Option<usize> {
        match self.dictionary.families[family].kind {
            Kind::Effect(e) => Some(e),
            _ => None,
        }
    }

    /// Whether the family is a generic dependence.
    pub fn is_generic(&self, family: usize) -> bool {
        matches!(self.dictionary.families[family].kind, Kind::Generic(_))
    }

    /// Whether the family is a further order of the base.
    pub fn is_order(&self, family: usize) -> bool {
        matches!(self.dictionary.families[family].kind, Kind::Order)
    }

    /// The base with the terms' columns, and the residual.
    pub fn fit(&self, terms: &[Term]) -> (Basis, Vec<f64>) {
        let mut basis = self.base.clone();
        for column in terms.iter().flat_map(|t| t.columns.iter()) {
            basis.add(&self.whitener.whiten(column));
        }
        let mut residual = self.target.clone();
        for k in self.base.rank()..basis.rank() {
            let a = dot(basis.columns.get(k), &residual);
            add_scaled(&mut residual, -a, basis.columns.get(k));
        }
        (basis, residual)
    }

    /// The price of a term.
    pub fn price(&self, term: &Term) -> f64 {
        let own = self.own_price(term);
        match self.effect(term.family) {
            Some(e) => {
                let form = self.columns_of_forms[e].map(|columns| self.price_of_form(columns, term));
                own + SHAPE_PRICE * self.free_shapes(e) as f64 + form.unwrap_or(0.0)
            }
            None if self.is_generic(term.family) => {
                own + handicap(term) + if self.with_forms { CURVE } else { 0.0 }
            }
            None => own,
        }
    }

    /// What a form must explain beyond a named effect: for every factor, and for every column beyond the first the choice
    /// of it among all columns.
    fn price_of_form(&self, columns: usize, term: &Term) -> f64 {
        HANDICAP
            + HANDICAP_PER_FACTOR * (term.columns.len() as f64 - 1.0)
            + self.choice_of_column * columns.saturating_sub(1) as f64
    }

    /// Whether a family may take part at all: beside forms no curve of what is recorded, which can be handed to nobody.
    fn takes_part(&self, family: usize) -> bool {
        let Kind::Generic(place) = &self.dictionary.families[family].kind else { return true };
        let of_time = |name: &str| ["t_s", "pass"].contains(&name);
        !self.with_forms || of_time(&place.variable) || place.times.as_deref().is_some_and(of_time)
    }

    /// How many shape parameters of an effect of the catalogue are free to take any value.
    pub fn free_shapes(&self, effect: usize) -> usize {
        if self.catalogue[effect].shape_follows {
            return 0;
        }
        self.ranges[effect].iter().filter(|r| r.high > r.low && !(r.whole && r.high <= 1.0)).count()
    }

    /// The price without what is set on top of it for comparisons.
    fn own_price(&self, term: &Term) -> f64 {
        let (known, rank) = (&self.prices[term.family], term.columns.len());
        match known.get(rank) {
            Some(price) => *price,
            // A richer form than any of the grid (further harmonics).
            None => self.calibration.price(term.family, self.shares[term.family], rank),
        }
    }

    /// Terms of a search with other effects as terms of this one.
    pub fn translated(&self, other: &Search, terms: &[Term]) -> Vec<Term> {
        let family = |term: &Term| {
            let kind = &other.dictionary.families[term.family].kind;
            self.dictionary.families.iter().position(|family| family.kind == *kind)
        };
        terms.iter().filter_map(|term| Some(Term { family: family(term)?, ..term.clone() })).collect()
    }

    /// What the terms explain less their prices.
    pub fn merit(&self, terms: &[Term]) -> f64 {
        self.explained(terms) - terms.iter().map(|t| self.price(t)).sum::<f64>()
    }

    /// The best candidate of every family, from the grid, beside the base grown by some columns, and the residual.
    fn survey_beside(&self, basis: &Basis, residual: &[f64]) -> Vec<Found> {
        let mut further = Columns::new(self.rows.len());
        (self.base.rank()..basis.rank()).for_each(|k| further.push(basis.columns.get(k)));
        let count = further.count();
        further.push(residual);
        let projected = self.projected();
        let products = projected.products(&further);
        let best_of = |f: usize| {
            let mut scratch = Scratch::default();
            let family = &self.dictionary.families[f];
            if let Some(jumps) = self.dictionary.jumps(family, &self.whitener, basis) {
                return self.best_step(f, &jumps, residual);
            }
            let mut possible: Vec<(f64, usize, f64)> = Vec::new();
            let mut explained_by = Vec::new();
            for c in family.candidates.clone() {
                projected.scores(c, &products, count, family.smallest_part, &mut scratch);
                let scores = &scratch.scores;
                let s = dot(scores, scores);
                explained_by.push(s);
                let pays = self.pays_beside_what_is_missing(f, scratch.own(projected, c));
                if scores.is_empty() || !self.possible(f, scores) || !pays {
                    continue;
                }
                possible.push((log_tail(s, scores.len()), c, s));
            }
            // Only few are asked whether they are plausible, which costs more than their scores.
            possible.sort_by(|a, b| b.0.total_cmp(&a.0));
            let best = possible.into_iter().find(|(_, c, ..)| self.plausible_beside(f, *c, basis, residual));
            best.map(|(m, c, explained)| {
                let candidate = &self.dictionary.candidates[c];
                let shape = candidate.shape.clone();
                Found {
                    term: Term {
                        rivals: Arc::new(self.rivals(f, &explained_by)),
                        ..Term::new(f, shape, Arc::clone(&candidate.columns))
                    },
                    explained,
                    surprise: self.calibration.families[f].surprise(m),
                }
            })
        };
        parallel::indices(0..self.dictionary.families.len(), best_of).into_iter().flatten().collect()
    }

    /// The one free shape parameter of a family at the tops of its grid that may be the highest once refined; nothing
    /// where that is one alone, or where the shape is no single number, in whose order tops are seen.
    fn rivals(&self, family: usize, explained: &[f64]) -> Vec<f64> {
        let Some(free) = self.effect(family).and_then(|e| self.only_free_shape(e)) else { return Vec::new() };
        let at = |k: usize| explained.get(k).copied().unwrap_or(0.0);
        // The height of the parabola through a top and its neighbours.
        let height = |k: usize| {
            let (before, here, after) = (at(k.wrapping_sub(1)), at(k), at(k + 1));
            let bend = (2.0 * here - before - after).max(f64::MIN_POSITIVE);
            here + 0.125 * (after - before).powi(2) / bend
        };
        let is_top = |k: &usize| at(*k) >= at(*k + 1) && (*k == 0 || at(*k) > at(*k - 1));
        let mut tops: Vec<(f64, usize)> =
            (0..explained.len()).filter(is_top).map(|k| (height(k), k)).collect();
        tops.sort_by(|a, b| b.0.total_cmp(&a.0));
        let highest = tops.first().map_or(0.0, |top| top.0);
        tops.retain(|top| top.0 * TOP_LOSS >= highest);
        if tops.len() < 2 {
            return Vec::new();
        }
        let first = self.dictionary.families[family].candidates.start;
        let value = |(_, k): &(f64, usize)| self.dictionary.candidates[first + k].shape[free];
        tops.iter().take(MOST_RIVALS).map(value).collect()
    }

    /// The place of an effect's shape parameter that is free to take any value, where that is one alone.
    fn only_free_shape(&self, effect: usize) -> Option<usize> {
        let free = |range: &Range| range.high > range.low && !range.whole;
        if self.free_shapes(effect) == 1 { self.ranges[effect].iter().position(free) } else { None }
    }

    /// The best step of a family that begins at a row.
    fn best_step(&self, family: usize, jumps: &Jumps, residual: &[f64]) -> Option<Found> {
        let (row, explained) = jumps.best(residual)?;
        let shape = vec![row as f64];
        let columns = self.over[self.effect(family)?].signature(&shape);
        Some(Found {
            term: Term::new(family, shape, Arc::new(columns)),
            explained,
            surprise: self.calibration.families[family].surprise(log_tail(explained, 1)),
        })
    }

    /// Whether scores of a candidate's own columns beside what is missing of it are worth their price. What is missing follows much
    /// that happened between pauses, and shows nothing.
    fn pays_beside_what_is_missing(&self, family: usize, own: &[f64]) -> bool {
        let known = &self.prices[family];
        self.dictionary.families[family].own.is_none()
            || dot(own, own) >= known[own.len().min(known.len() - 1)]
    }

    /// Whether scores of one sign can be this family's.
    fn possible(&self, family: usize, scores: &[f64]) -> bool {
        match self.effect(family) {
            Some(e) if scores.len() == 1 => self.catalogue[e].plausible_sign(scores[0]),
            _ => true,
        }
    }

    /// Whether candidate `c` of an effect with several columns has amplitudes beside a basis that can be this effect's.
    fn plausible_beside(&self, family: usize, c: usize, basis: &Basis, residual: &[f64]) -> bool {
        let candidate = &self.dictionary.candidates[c];
        let limited = |e: &usize| candidate.columns.len() > 1 && self.catalogue[*e].limits_amplitudes();
        let Some(e) = self.effect(family).filter(limited) else { return true };
        let left = candidate.columns.iter().map(|column| {
            let mut w = self.whitener.whiten(column);
            basis.project_off(&mut w);
            w
        });
        let amplitudes = least_squares(&left.collect::<Vec<_>>(), residual).coefficients;
        self.catalogue[e].plausible_at(self.rows, &candidate.shape, &amplitudes)
    }

    /// Whether a found family passes the threshold of the whole search.
    pub fn significant(&self, found: &Found) -> bool {
        found.surprise + self.shares[found.term.family].ln() >= self.calibration.threshold
    }

    /// −ln of the family-wise p-value.
    pub fn family_wise(&self, found: &Found) -> f64 {
        self.calibration.family_wise(found.surprise, self.shares[found.term.family])
    }
}

/// What a generic term must explain beyond a catalogued one: the more columns, the more physics it swallows.
fn handicap(term: &Term) -> f64 {
    GENERIC_HANDICAP + HANDICAP_PER_COLUMN * (term.columns.len() as f64 - 1.0)
}

/// The whitened base and the observations less it.
fn base_and_target(rows: &Rows, order: usize, noise: &Noise) -> (Basis, Vec<f64>) {
    let mut base = Basis::new(rows.len());
    let whitener = noise.whitener();
    for column in base_columns(rows, order) {
        base.add(&whitener.whiten(&column));
    }
    let mut target = whitener.whiten(&noise.clean);
    base.project_off(&mut target);
    (base, target)
}
