//! The search for the set of explanations that accounts for a recording: forward, with exchange and
//! backward steps, every candidate judged jointly with the others after projecting off what the base model
//! absorbs. A set's merit is what it explains of the whitened sum of squares less a price per term, and the
//! price is what the strongest of the family's candidates explains in one recording of nothing in
//! [`crate::calibrate::FALSE_ALARMS`]⁻¹: no i.i.d. information criterion.

use std::sync::Arc;

use crate::base::base_columns;
use crate::calibrate::{Calibration, GENERIC_SHARE, calibrate, log_tail};
use crate::dictionary::{Dictionary, Kind, Projected, Scratch};
use crate::effects::Effect;
use crate::linear::{Basis, Columns, add_scaled, dot};
use crate::noise::Noise;
use crate::rows::Rows;

/// Most terms in a model.
const MOST_TERMS: usize = 6;
/// Generic terms after which the search stops: what is left is located well enough to be looked into.
const MOST_GENERIC: usize = 2;
/// Terms up to which one is tried in the place of two.
const MOST_FOR_PAIRS: usize = 3;
/// Contenders for the first of two terms that are exchanged at once.
const FIRST_OF_PAIRS: usize = 6;
/// What a generic term must explain beyond a catalogued one to be preferred: a curve always follows an
/// effect's signature, and a χ² of its further columns must not be enough to unseat the physics.
const GENERIC_HANDICAP: f64 = 5.0;
/// The same for every column beyond the first.
const HANDICAP_PER_COLUMN: f64 = 1.5;
/// What every shape parameter must explain in addition: of two explanations that nearly tie, the simpler, of
/// which the richer one often is a limiting case (a lag without delay, a warm-up that never ends).
pub const SHAPE_PRICE: f64 = 3.0;
/// Merit by which an exchange must win.
const EXCHANGE_MARGIN: f64 = 0.3;
/// Merit that a joint refinement may bring at most, for a set to be worth refining.
const NEAR: f64 = 12.0;
/// Families that are refined before they are compared, at most.
const REFINED: usize = 5;

/// One term of a model.
#[derive(Debug, Clone)]
pub struct Term {
    /// Its family in the dictionary.
    pub family: usize,
    /// Its shape parameters.
    pub shape: Vec<f64>,
    /// Its raw columns.
    pub columns: Vec<Vec<f64>>,
}

/// A candidate as it stands beside a model.
#[derive(Debug, Clone)]
pub struct Found {
    /// The term it would be.
    pub term: Term,
    /// What it explains beyond the model.
    pub explained: f64,
    /// Its rank after projection.
    pub rank: usize,
    /// −ln of its family's p-value.
    pub surprise: f64,
}

/// Everything that a search of one recording needs.
pub struct Search<'a> {
    /// The recording.
    pub rows: &'a Rows,
    /// The catalogue.
    pub catalogue: &'a [Box<dyn Effect>],
    /// The candidates.
    pub dictionary: Arc<Dictionary>,
    /// The noise used for whitening.
    pub noise: Noise,
    /// The calibration of the whole search.
    pub calibration: Calibration,
    /// Share of the false alarms per family.
    pub shares: Vec<f64>,
    /// Price of a term by family and rank.
    prices: Vec<Vec<f64>>,
    /// Free shape parameters of every effect of the catalogue.
    free_shapes: Vec<usize>,
    base_order: usize,
    /// The candidates beside the base.
    projected: Projected,
    base: Basis,
    /// Whitened cleaned observations less the base.
    target: Vec<f64>,
}

impl<'a> Search<'a> {
    /// Prepares the search: whitens, projects, calibrates.
    pub fn new(
        rows: &'a Rows,
        catalogue: &'a [Box<dyn Effect>],
        order: usize,
        noise: Noise,
        skip: &[String],
    ) -> Search<'a> {
        let dictionary = Arc::new(Dictionary::new(rows, catalogue, order, skip));
        let whitened = dictionary.whitened(&noise);
        let (base, target) = base_and_target(rows, order, &noise);
        let shares: Vec<f64> = dictionary
            .families
            .iter()
            .map(|f| if matches!(f.kind, Kind::Generic(_)) { GENERIC_SHARE } else { 1.0 })
            .collect();
        let projected = dictionary.project(&whitened, &base);
        // The order of the base is no mismatch: it takes no part in the alarm.
        let alarm: Vec<f64> = dictionary
            .families
            .iter()
            .zip(&shares)
            .map(|(f, s)| if matches!(f.kind, Kind::Order) { 0.0 } else { *s })
            .collect();
        let calibration = calibrate(&dictionary, &projected, catalogue, &noise, &rows.reading, &alarm);
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
            dictionary,
            noise,
            calibration,
            shares,
            prices,
            free_shapes: catalogue
                .iter()
                .map(|e| {
                    e.ranges(rows).iter().filter(|r| r.high > r.low && !(r.whole && r.high <= 1.0)).count()
                })
                .collect(),
            base_order: order,
            projected,
            base,
            target,
        }
    }

    /// The same search with another noise (rows that count as unmeasured), its calibration kept.
    pub fn with_noise(whole: &Search<'a>, noise: Noise) -> Search<'a> {
        let order = whole.base_order;
        let dictionary = Arc::clone(&whole.dictionary);
        let (base, target) = base_and_target(whole.rows, order, &noise);
        let projected = dictionary.project(&dictionary.whitened(&noise), &base);
        Search {
            rows: whole.rows,
            catalogue: whole.catalogue,
            dictionary,
            noise,
            calibration: whole.calibration.clone(),
            shares: whole.shares.clone(),
            prices: whole.prices.clone(),
            free_shapes: whole.free_shapes.clone(),
            base_order: order,
            projected,
            base,
            target,
        }
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

    /// The base with the terms' columns, and the residual.
    pub fn fit(&self, terms: &[Term]) -> (Basis, Vec<f64>) {
        let mut basis = self.base.clone();
        for column in terms.iter().flat_map(|t| &t.columns) {
            basis.add(&self.noise.whiten(column));
        }
        let mut residual = self.target.clone();
        for k in self.base.rank()..basis.rank() {
            let a = dot(basis.columns.get(k), &residual);
            add_scaled(&mut residual, -a, basis.columns.get(k));
        }
        (basis, residual)
    }

    /// What the terms explain together.
    pub fn explained(&self, terms: &[Term]) -> f64 {
        let (_, residual) = self.fit(terms);
        dot(&self.target, &self.target) - dot(&residual, &residual)
    }

    /// The price of a term.
    pub fn price(&self, term: &Term) -> f64 {
        let own = self.own_price(term);
        match self.effect(term.family) {
            Some(e) => own + SHAPE_PRICE * self.free_shapes(e) as f64,
            None if self.is_generic(term.family) => own + handicap(term),
            None => own,
        }
    }

    /// How many shape parameters of an effect of the catalogue are free to take any value.
    pub fn free_shapes(&self, effect: usize) -> usize {
        self.free_shapes[effect]
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

    /// What the terms explain less their prices.
    pub fn merit(&self, terms: &[Term]) -> f64 {
        self.explained(terms) - terms.iter().map(|t| self.price(t)).sum::<f64>()
    }

    /// The best candidate of every family beside the given terms, from the grid.
    pub fn survey(&self, terms: &[Term]) -> Vec<Found> {
        let (basis, residual) = self.fit(terms);
        self.survey_beside(&basis, &residual)
    }

    /// The same beside the base grown by some columns, and the residual.
    fn survey_beside(&self, basis: &Basis, residual: &[f64]) -> Vec<Found> {
        let mut found = Vec::new();
        let mut further = Columns::new(self.rows.len());
        (self.base.rank()..basis.rank()).for_each(|k| further.push(basis.columns.get(k)));
        let count = further.count();
        further.push(residual);
        let products = self.projected.products(&further);
        let mut scratch = Scratch::default();
        for (f, family) in self.dictionary.families.iter().enumerate() {
            let mut best: Option<(f64, usize, f64, usize)> = None;
            for c in family.candidates.clone() {
                self.projected.scores(c, &products, count, family.smallest_part, &mut scratch);
                let scores = &scratch.scores;
                if scores.is_empty() || !self.possible(f, scores) {
                    continue;
                }
                let s = dot(scores, scores);
                let m = log_tail(s, scores.len());
                if best.is_none_or(|b| m > b.0) {
                    best = Some((m, c, s, scores.len()));
                }
            }
            if let Some((m, c, s, rank)) = best {
                let candidate = &self.dictionary.candidates[c];
                let columns =
                    candidate.columns.clone().map(|k| self.dictionary.raw.get(k).to_vec()).collect();
                found.push(Found {
                    term: Term { family: f, shape: candidate.shape.clone(), columns },
                    explained: s,
                    rank,
                    surprise: self.calibration.families[f].surprise(m),
                });
            }
        }
        found
    }

    /// Whether scores of one sign can be this family's.
    fn possible(&self, family: usize, scores: &[f64]) -> bool {
        match self.effect(family) {
            Some(e) if scores.len() == 1 => self.catalogue[e].plausible(scores),
            _ => true,
        }
    }

    /// Whether a found family passes the threshold of the whole search.
    pub fn significant(&self, found: &Found) -> bool {
        found.surprise + self.shares[found.term.family].ln() >= self.calibration.threshold
    }

    /// −ln of the family-wise p-value.
    pub fn family_wise(&self, found: &Found) -> f64 {
        self.calibration.family_wise(found.surprise, self.shares[found.term.family])
    }

    /// What a shape of an effect explains beside a basis, with its scores.
    fn try_shape(&self, family: usize, shape: &[f64], basis: &Basis, residual: &[f64]) -> Option<Found> {
        let e = self.effect(family)?;
        if !self.catalogue[e].possible_shape(self.rows, shape) {
            return None;
        }
        let columns = self.catalogue[e].signature(self.rows, shape);
        let mut own = Basis::new(self.rows.len());
        for column in &columns {
            let mut w = self.noise.whiten(column);
            let length = dot(&w, &w).sqrt();
            basis.project_off(&mut w);
            if dot(&w, &w).sqrt() > self.dictionary.families[family].smallest_part * length {
                own.add(&w);
            }
        }
        let scores: Vec<f64> = (0..own.rank()).map(|k| dot(own.columns.get(k), residual)).collect();
        if scores.is_empty() || !self.possible(family, &scores) {
            return None;
        }
        let explained = dot(&scores, &scores);
        let surprise = self.calibration.families[family].surprise(log_tail(explained, scores.len()));
        Some(Found {
            term: Term { family, shape: shape.to_vec(), columns },
            explained,
            rank: scores.len(),
            surprise,
        })
    }

    /// Improves the shape of a candidate beside a model by a compass search.
    pub fn refine(&self, found: Found, basis: &Basis, residual: &[f64]) -> Found {
        let family = found.term.family;
        let Some(e) = self.effect(family) else { return found };
        let effect = &self.catalogue[e];
        let mut best = found;
        if effect.consistent_shape(&[1.0]).is_some() {
            return self.make_consistent(best, basis, residual);
        }
        let ranges = effect.ranges(self.rows);
        if ranges.is_empty() {
            return best;
        }
        let mut steps = self.first_steps(family, &best.term.shape);
        let least: Vec<f64> = steps.iter().map(|s| s * 2e-3).collect();
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
                for sign in [1.0, -1.0] {
                    let mut shape = best.term.shape.clone();
                    let value = if ranges[k].logarithmic {
                        shape[k] * (sign * steps[k]).exp()
                    } else if whole {
                        shape[k] + sign * steps[k].round()
                    } else {
                        shape[k] + sign * steps[k]
                    };
                    shape[k] = value.clamp(ranges[k].low, ranges[k].high);
                    if shape[k] == best.term.shape[k] {
                        continue;
                    }
                    if let Some(next) = self.try_shape(family, &shape, basis, residual)
                        && next.explained > best.explained
                    {
                        best = next;
                        here = true;
                        break;
                    }
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
        let ranges = self.catalogue[e].ranges(self.rows);
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

    /// Solves for a shape that is its own amplitude.
    fn make_consistent(&self, found: Found, basis: &Basis, residual: &[f64]) -> Found {
        let family = found.term.family;
        let Some(e) = self.effect(family) else { return found };
        let mut best = found;
        for _ in 0..4 {
            let column = self.noise.whiten(&best.term.columns[0]);
            let mut w = column.clone();
            basis.project_off(&mut w);
            let amplitude = dot(&w, residual) / dot(&w, &w).max(1e-300);
            let Some(shape) = self.catalogue[e].consistent_shape(&[amplitude]) else { return best };
            match self.try_shape(family, &shape, basis, residual) {
                Some(next) => best = next,
                None => return best,
            }
        }
        best
    }

    /// Refines every term in turn beside the others, and tries richer forms.
    pub fn backfit(&self, terms: &mut [Term]) {
        for sweep in 0..2 {
            for k in 0..terms.len() {
                let Some(e) = self.effect(terms[k].family) else { continue };
                if self.catalogue[e].ranges(self.rows).is_empty() || (terms.len() == 1 && sweep > 0) {
                    continue;
                }
                let others: Vec<Term> =
                    terms.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, t)| t.clone()).collect();
                let (basis, residual) = self.fit(&others);
                let Some(start) = self.try_shape(terms[k].family, &terms[k].shape, &basis, &residual) else {
                    continue;
                };
                let mut best = self.refine(start, &basis, &residual);
                let plain = best.term.shape.clone();
                while let Some(shape) = self.catalogue[e].richer(self.rows, &best.term.shape) {
                    let Some(richer) = self.try_shape(best.term.family, &shape, &basis, &residual) else {
                        break;
                    };
                    // A further harmonic: two more columns, at the level of one test in some hundred.
                    if richer.explained - best.explained < 2.0 * 5.3 {
                        break;
                    }
                    best = richer;
                }
                // The shape hardly moves with its richness: once refined again at the end is enough.
                if best.term.shape != plain {
                    best = self.refine(best, &basis, &residual);
                }
                terms[k] = best.term;
            }
        }
    }

    /// The best candidates beside the terms by merit, refined; `wanted` filters families.
    pub fn contenders(&self, terms: &[Term], wanted: impl Fn(usize) -> bool) -> Vec<Found> {
        let (basis, residual) = self.fit(terms);
        let mut found: Vec<Found> = self
            .survey_beside(&basis, &residual)
            .into_iter()
            .filter(|f| wanted(f.term.family) && self.allowed_beside(f.term.family, terms))
            .collect();
        found.sort_by(|a, b| self.gain(b).total_cmp(&self.gain(a)));
        let best = found.first().map_or(0.0, |f| self.gain(f));
        let mut refined = 0;
        let mut out: Vec<Found> = found
            .into_iter()
            .map(|f| {
                // Refinement brings at most what the grid lost: a third, generously.
                let shaped = self.effect(f.term.family).is_some() && !f.term.shape.is_empty();
                if shaped && refined < REFINED && f.explained * 1.5 > best.max(0.0) {
                    refined += 1;
                    self.refine(f, &basis, &residual)
                } else {
                    f
                }
            })
            .collect();
        out.sort_by(|a, b| self.gain(b).total_cmp(&self.gain(a)));
        out
    }

    /// Whether a family may stand beside these terms: an effect that cannot repeat only once.
    fn allowed_beside(&self, family: usize, terms: &[Term]) -> bool {
        let repeatable = self.effect(family).is_none_or(|e| self.catalogue[e].repeatable());
        let already = terms.iter().filter(|t| t.family == family).count();
        already < if repeatable { 2 } else { 1 }
    }

    /// What a candidate adds to the merit.
    pub fn gain(&self, found: &Found) -> f64 {
        found.explained - self.price(&found.term)
    }

    /// Searches from `start` until nothing significant is left and no exchange improves the merit: once with
    /// the catalogue before anything without a name, and, where one name does not account for everything,
    /// once with all together, because a curve that is taken first may hide two effects, and two effects may
    /// imitate what has no name. The better set is kept.
    pub fn run(&self, start: Vec<Term>) -> Vec<Term> {
        let named = self.grow(start.clone(), true);
        let named = self.grow(named, false);
        if named.len() <= 1 && !named.iter().any(|t| self.is_generic(t.family)) {
            return named;
        }
        let free = self.grow(start, false);
        if self.merit(&free) > self.merit(&named) + EXCHANGE_MARGIN { free } else { named }
    }

    /// Exchanges two terms at once for two of the catalogue: a time constant that was refined beside the wrong
    /// partner makes the right one look worse than it is, and neither gives way alone.
    pub fn reshuffle(&self, terms: Vec<Term>) -> Vec<Term> {
        let mut terms = terms;
        for _ in 0..2 {
            if terms.len() < 2 || terms.len() > MOST_FOR_PAIRS + 1 {
                return terms;
            }
            let merit = self.merit(&terms);
            let mut better: Option<(f64, Vec<Term>)> = None;
            for k in 0..terms.len() {
                for j in k + 1..terms.len() {
                    let mut rest = terms.clone();
                    rest.remove(j);
                    rest.remove(k);
                    for set in self.pairs_beside(&rest) {
                        if self.merit(&set) < merit - NEAR {
                            continue;
                        }
                        let mut set = set;
                        self.backfit(&mut set);
                        let m = self.merit(&set);
                        if m > merit + EXCHANGE_MARGIN && better.as_ref().is_none_or(|b| m > b.0) {
                            better = Some((m, set));
                        }
                    }
                }
            }
            match better {
                Some((_, set)) => terms = set,
                None => return terms,
            }
        }
        terms
    }

    /// Promising pairs of catalogued effects beside the terms, with them.
    fn pairs_beside(&self, terms: &[Term]) -> Vec<Vec<Term>> {
        let named = |f: usize| self.effect(f).is_some();
        let mut out = Vec::new();
        for first in self.contenders(terms, named).into_iter().take(FIRST_OF_PAIRS) {
            let mut with = terms.to_vec();
            with.push(first.term);
            for second in self.contenders(&with, named).into_iter().take(2) {
                let mut pair = with.clone();
                pair.push(second.term);
                out.push(pair);
            }
        }
        out
    }

    /// Adds and exchanges terms, only catalogued ones where `named_only`.
    fn grow(&self, start: Vec<Term>, named_only: bool) -> Vec<Term> {
        let mut terms = start;
        self.backfit(&mut terms);
        self.exchange(&mut terms, named_only);
        for _ in 0..2 * MOST_TERMS {
            let unexplained = terms.iter().filter(|t| self.is_generic(t.family)).count();
            if terms.len() >= MOST_TERMS || unexplained >= MOST_GENERIC {
                break;
            }
            let contenders = self.contenders(&terms, |f| !named_only || !self.is_generic(f));
            let Some(next) = contenders.into_iter().find(|f| self.significant(f)) else { break };
            terms.push(next.term);
            self.backfit(&mut terms);
            self.exchange(&mut terms, named_only);
        }
        self.prune(&mut terms);
        terms
    }

    /// Drops terms that no longer pay.
    fn prune(&self, terms: &mut Vec<Term>) {
        loop {
            let whole = self.explained(terms);
            let weakest = (0..terms.len())
                .map(|k| {
                    let mut without = terms.clone();
                    let term = without.remove(k);
                    let own =
                        self.calibration.price(term.family, self.shares[term.family], term.columns.len());
                    (k, whole - self.explained(&without) - own)
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((k, surplus)) if surplus < 0.0 => {
                    terms.remove(k);
                }
                _ => return,
            }
        }
    }

    /// Exchanges terms for better ones, drops those that do not pay, and tries two catalogued effects in
    /// place of a generic one.
    fn exchange(&self, terms: &mut Vec<Term>, named_only: bool) {
        let wanted = |f: usize| !named_only || !self.is_generic(f);
        let mut merit = self.merit(terms);
        for _ in 0..4 {
            let mut better: Option<(f64, Vec<Term>)> = None;
            let mut consider = |candidate: Vec<Term>, merit_of: f64| {
                if better.as_ref().is_none_or(|b| merit_of > b.0) {
                    better = Some((merit_of, candidate));
                }
            };
            for k in 0..terms.len() {
                let mut without = terms.clone();
                let removed = without.remove(k);
                let merit_without = self.merit(&without);
                if terms.len() > 1 {
                    // The handicap is for comparisons with physics, not with nothing.
                    let lost = if self.is_generic(removed.family) { handicap(&removed) } else { 0.0 };
                    consider(without.clone(), merit_without - lost);
                }
                let others = self.contenders(&without, |f| f != removed.family && wanted(f));
                for other in others.iter().take(2) {
                    let mut with = without.clone();
                    with.push(other.term.clone());
                    // Refining all terms together brings little: only a near contender is worth it.
                    if self.merit(&with) > merit - NEAR {
                        self.backfit(&mut with);
                        let m = self.merit(&with);
                        consider(with, m);
                    }
                }
                if self.is_generic(removed.family) || terms.len() == 1 {
                    let catalogued = others.iter().filter(|o| self.effect(o.term.family).is_some());
                    for first in catalogued.take(3) {
                        let mut with = without.clone();
                        with.push(first.term.clone());
                        let second = self.contenders(&with, |f| self.effect(f).is_some());
                        if let Some(second) = second.into_iter().next() {
                            with.push(second.term);
                            if self.merit(&with) > merit - NEAR {
                                self.backfit(&mut with);
                                let m = self.merit(&with);
                                consider(with, m);
                            }
                        }
                    }
                }
            }
            // One explanation in the place of two.
            let few = if terms.len() <= MOST_FOR_PAIRS { terms.len() } else { 0 };
            for k in 0..few {
                for j in k + 1..few {
                    let mut with: Vec<Term> = terms.clone();
                    with.remove(j);
                    with.remove(k);
                    if let Some(one) = self.contenders(&with, wanted).into_iter().next() {
                        with.push(one.term);
                        let m = self.merit(&with);
                        consider(with, m);
                    }
                }
            }
            match better {
                Some((m, candidate)) if m > merit + EXCHANGE_MARGIN => {
                    *terms = candidate;
                    merit = m;
                }
                _ => return,
            }
        }
    }
}

/// What a generic term must explain beyond a catalogued one: the more columns, the more physics it swallows.
fn handicap(term: &Term) -> f64 {
    GENERIC_HANDICAP + HANDICAP_PER_COLUMN * (term.columns.len() as f64 - 1.0)
}

/// The whitened base and the observations less it.
fn base_and_target(rows: &Rows, order: usize, noise: &Noise) -> (Basis, Vec<f64>) {
    let mut base = Basis::new(rows.len());
    for column in base_columns(rows, order) {
        base.add(&noise.whiten(&column));
    }
    let mut target = noise.whiten(&noise.clean);
    base.project_off(&mut target);
    (base, target)
}
