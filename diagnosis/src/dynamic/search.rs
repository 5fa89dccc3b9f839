//! Which effects: forward by screening and full refits, each chosen on rows that did not fit it, then
//! backward, and with exchanges. The way in which the drive runs between its samples is chosen anew with
//! every effect, since a missing effect can hide it.

mod exchange;
mod grow;
mod rare_saturation;

use super::data::{ALL, Data};
use super::effects::{CATALOGUE, DynamicEffect};
use super::estimate::{Fitted, fit};
use super::model::Term;
use super::noise::autoregression;
use crate::dynamic::data::FOLDS;
use crate::thresholds::dynamic::estimate::PATIENCE;
use crate::thresholds::dynamic::search::{
    GAIN_PER_PARAMETER, LEAST_GAIN, LEAST_PART, MOST_EXCHANGES, RARE_GAIN,
};

/// Rows that fit.
pub const FIT_ROWS: [bool; FOLDS] = [true, false, false];
/// Rows that choose.
pub const CHOOSE_ROWS: [bool; FOLDS] = [false, true, false];

/// What a model gains over another on some rows, as −2 log likelihood of white noise.
pub fn gain(before: &Fitted, after: &Fitted, folds: [bool; FOLDS]) -> f64 {
    let rows: usize = (0..FOLDS).filter(|f| folds[*f]).map(|f| before.rows[f]).sum();
    let ratio = before.cost(folds).max(f64::MIN_POSITIVE) / after.cost(folds).max(f64::MIN_POSITIVE);
    rows as f64 * ratio.ln()
}

/// What a model gains over another, residuals of both passed through one filter.
struct Gains {
    /// Squared residuals of the one, by kind of row.
    old: [f64; FOLDS],
    /// Of the other.
    new: [f64; FOLDS],
    /// Squares of what the two are apart.
    apart: [f64; FOLDS],
    /// Rows.
    rows: [usize; FOLDS],
    /// Factor of the variance of a gain over that in white noise.
    spread: f64,
}

impl Gains {
    /// −2 log likelihood gained on some rows.
    fn of(&self, folds: [bool; FOLDS]) -> f64 {
        let sum = |costs: &[f64; FOLDS]| (0..FOLDS).filter(|f| folds[*f]).map(|f| costs[f]).sum::<f64>();
        let ratio = sum(&self.old).max(f64::MIN_POSITIVE) / sum(&self.new).max(f64::MIN_POSITIVE);
        self.count(folds) * ratio.ln()
    }

    fn count(&self, folds: [bool; FOLDS]) -> f64 {
        (0..FOLDS).filter(|f| folds[*f]).map(|f| self.rows[f]).sum::<usize>() as f64
    }

    /// What the other gains on some rows if it is right.
    fn due(&self, folds: [bool; FOLDS]) -> f64 {
        let sum = |squares: &[f64; FOLDS]| (0..FOLDS).filter(|f| folds[*f]).map(|f| squares[f]).sum::<f64>();
        self.count(folds) * (sum(&self.apart) / sum(&self.new).max(f64::MIN_POSITIVE)).ln_1p()
    }

    /// Whether it gains that, less three standard deviations at most, each of them twice the root of what is due in
    /// white noise.
    fn as_due(&self, folds: [bool; FOLDS]) -> bool {
        let due = self.due(folds);
        self.of(folds) > due - 6.0 * (self.spread * due).sqrt()
    }
}

/// The search.
pub struct Search<'a> {
    /// The axis.
    pub data: &'a Data<'a>,
    /// The effects that may be named.
    pub catalogue: Vec<&'static dyn DynamicEffect>,
    /// Number of terms, the first ones, that the nominal plant has and that are not in question.
    pub given: usize,
}

impl<'a> Search<'a> {
    /// A search in the catalogue without the effects `skip`, beside a nominal plant of `given` terms.
    pub fn new(data: &'a Data<'a>, skip: &[String], given: usize) -> Search<'a> {
        let catalogue = CATALOGUE.iter().copied().filter(|e| skip.iter().all(|id| id != e.id)).collect();
        Search { data, catalogue, given }
    }

    /// The whitening filter of a model's residual.
    pub fn whitening(&self, fitted: &Fitted) -> Vec<f64> {
        let Ok(y) = fitted.positions(self.data) else { return Vec::new() };
        let residual: Vec<f64> = self.data.position.iter().zip(&y).map(|(a, b)| a - b).collect();
        autoregression(&residual, &self.data.runs).coefficients
    }

    /// Whether a term's parameters can be its effect.
    fn sound(&self, term: &Term) -> bool {
        let finite = term.parameters.iter().all(|v| v.is_finite());
        finite && term.effect.plausible(&term.parameters, &self.data.scale)
    }

    /// Whether the last effect of `after` is worth its parameters beside `before`.
    fn worth(&self, before: &Fitted, after: &Fitted) -> bool {
        let further = after.model.free().saturating_sub(before.model.free() + 1) as f64;
        let least = LEAST_GAIN + GAIN_PER_PARAMETER * further;
        let part = |folds| LEAST_PART * self.data.count(folds) as f64;
        self.compared(before, after).is_some_and(|all| {
            all.iter().all(|gains| {
                let (fitted, chosen) = (gains.of(FIT_ROWS), gains.of(CHOOSE_ROWS));
                let plenty = fitted > least.max(part(FIT_ROWS));
                let there = (0.25 * least).max(part(CHOOSE_ROWS));
                // What acts rarely may hardly act on the rows that choose.
                plenty && (chosen > there || (fitted > RARE_GAIN * least && gains.as_due(CHOOSE_ROWS)))
            })
        })
    }

    /// What a model gains over another, before and, since noise that is alike in samples that follow counts for less
    /// than its rows, after both residuals have passed the filter that whitens the better one's; none where a
    /// model cannot be simulated.
    fn compared(&self, before: &Fitted, after: &Fitted) -> Option<Vec<Gains>> {
        let (old, new) = (before.positions(self.data).ok()?, after.positions(self.data).ok()?);
        let recorded = self.data.position;
        let residual: Vec<f64> = recorded.iter().zip(&new).map(|(a, b)| a - b).collect();
        let noise = autoregression(&residual, &self.data.runs);
        let passed = |filter: &[f64], spread: f64| {
            let mut gains =
                Gains { old: [0.0; FOLDS], new: [0.0; FOLDS], apart: [0.0; FOLDS], rows: [0; FOLDS], spread };
            for run in &self.data.runs {
                for k in run.start + filter.len()..run.end {
                    let at = |values: &[f64], k: usize| recorded[k] - values[k];
                    let white = |values: &[f64]| {
                        let past = filter.iter().enumerate().map(|(j, c)| c * at(values, k - 1 - j));
                        at(values, k) - past.sum::<f64>()
                    };
                    let (old, new, fold) = (white(&old), white(&new), self.data.fold[k] as usize);
                    gains.old[fold] += old * old;
                    gains.new[fold] += new * new;
                    gains.apart[fold] += (old - new).powi(2);
                    gains.rows[fold] += 1;
                }
            }
            gains
        };
        // Noise that is alike in samples that follow spreads a sum over slow terms as its density at rest does.
        let density = noise.innovation / (1.0 - noise.coefficients.iter().sum::<f64>()).abs().max(1e-3);
        let mut all = vec![passed(&[], (density / after.rms(ALL).max(f64::MIN_POSITIVE)).powi(2).max(1.0))];
        if !noise.coefficients.is_empty() {
            all.push(passed(&noise.coefficients, 1.0));
        }
        Some(all)
    }

    /// The effects beside the nominal plants (one per way of running between the samples), on the rows that
    /// fit and choose.
    pub fn run(&self, nominal: &Fitted) -> Fitted {
        let refit = |f: &Fitted| fit(&f.model, &f.states, self.data, FIT_ROWS, PATIENCE);
        let Some(mut present) = refit(nominal) else { return nominal.clone() };
        for _ in 0..MOST_EXCHANGES {
            present = self.grown(present);
            match self.exchanged(&present) {
                Some(better) => present = better,
                None => break,
            }
        }
        present
    }

    /// The model fitted to all rows.
    pub fn complete(&self, chosen: &Fitted) -> Fitted {
        fit(&chosen.model, &chosen.states, self.data, ALL, PATIENCE).unwrap_or_else(|| chosen.clone())
    }
}

/// Id of the last term.
pub fn last_id(fitted: &Fitted) -> &'static str {
    fitted.model.terms.last().map_or("", |t| t.effect.id)
}
