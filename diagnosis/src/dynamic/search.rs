//! Which effects: forward by screening and full refits, each chosen on rows that did not fit it, then
//! backward, and with exchanges. The way in which the drive runs between its samples is chosen anew with
//! every effect, since a missing effect can hide it.

mod exchange;
mod grow;
mod rare_saturation;

use super::data::{ALL, CHOOSE_ROWS, Data, FIT_ROWS, FOLDS, Folds, over};
use super::effects::{CATALOGUE, DynamicEffect};
use super::estimate::{Fitted, Simulated, fit};
use super::model::{Model, Term};
use super::noise::autoregression;
use crate::thresholds::dynamic::search::{
    GAIN_PER_PARAMETER, LEAST_GAIN, LEAST_PART, MOST_EXCHANGES, RARE_GAIN,
};

/// What a model gains over another on some rows, as −2 log likelihood of white noise.
pub fn gain<M: Simulated>(before: &Fitted<M>, after: &Fitted<M>, folds: Folds) -> f64 {
    let ratio = before.cost(folds).max(f64::MIN_POSITIVE) / after.cost(folds).max(f64::MIN_POSITIVE);
    over(folds, &before.rows) as f64 * ratio.ln()
}

/// What a model gains over another, residuals of both passed through one filter.
struct Gains {
    /// Squared residuals of the one, by kind of row.
    old: [f64; FOLDS],
    /// Of the other.
    new: [f64; FOLDS],
    /// Squares of what the two are apart.
    apart: [f64; FOLDS],
    rows: [usize; FOLDS],
    /// Factor of the variance of a gain over that in white noise.
    spread: f64,
}

impl Gains {
    /// −2 log likelihood gained on some rows.
    fn of(&self, folds: Folds) -> f64 {
        let sum = |costs: &[f64; FOLDS]| over(folds, costs).max(f64::MIN_POSITIVE);
        over(folds, &self.rows) as f64 * (sum(&self.old) / sum(&self.new)).ln()
    }

    /// What the other gains on some rows if it is right.
    fn due(&self, folds: Folds) -> f64 {
        let part = over(folds, &self.apart) / over(folds, &self.new).max(f64::MIN_POSITIVE);
        over(folds, &self.rows) as f64 * part.ln_1p()
    }

    /// Whether it gains that, less three standard deviations at most, each of them twice the root of what is due in
    /// white noise.
    fn as_due(&self, folds: Folds) -> bool {
        let due = self.due(folds);
        self.of(folds) > due - 6.0 * (self.spread * due).sqrt()
    }
}

/// Whether the last effect of `after` is worth its parameters beside `before`.
pub fn worth<M: Simulated>(data: &Data, before: &Fitted<M>, after: &Fitted<M>) -> bool {
    let further = after.model.packed().len().saturating_sub(before.model.packed().len() + 1) as f64;
    let least = LEAST_GAIN + GAIN_PER_PARAMETER * further;
    let part = |folds| LEAST_PART * data.count(folds) as f64;
    compared(data, before, after).is_some_and(|all| {
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
fn compared<M: Simulated>(data: &Data, before: &Fitted<M>, after: &Fitted<M>) -> Option<Vec<Gains>> {
    let (old, new) = (before.residual(data)?, after.residual(data)?);
    let noise = autoregression(&new, &data.runs);
    let passed = |filter: &[f64], spread: f64| {
        let mut gains =
            Gains { old: [0.0; FOLDS], new: [0.0; FOLDS], apart: [0.0; FOLDS], rows: [0; FOLDS], spread };
        for run in &data.runs {
            for k in run.start + filter.len()..run.end {
                let white = |residual: &[f64]| {
                    let past = filter.iter().enumerate().map(|(j, c)| c * residual[k - 1 - j]);
                    residual[k] - past.sum::<f64>()
                };
                let (old, new, fold) = (white(&old), white(&new), data.fold[k] as usize);
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

/// The search.
pub struct Search<'a> {
    pub data: &'a Data<'a>,
    /// The effects that may be named.
    pub catalogue: Vec<&'static DynamicEffect>,
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
        let residual = fitted.residual(self.data);
        residual.map_or_else(Vec::new, |r| autoregression(&r, &self.data.runs).coefficients)
    }

    /// Whether a term's parameters can be its effect.
    fn sound(&self, term: &Term) -> bool {
        let finite = term.parameters.iter().all(|v| v.is_finite());
        finite && (term.effect.plausible)(&term.parameters, &self.data.scale)
    }

    /// A model fitted to the rows that fit.
    pub fn fit(&self, model: &Model, states: &[[f64; 2]]) -> Option<Fitted> {
        fit(model, states, self.data, FIT_ROWS)
    }

    /// The effects beside the nominal plants (one per way of running between the samples), on the rows that
    /// fit and choose.
    pub fn run(&self, nominal: &Fitted) -> Fitted {
        let Some(mut present) = self.fit(&nominal.model, &nominal.states) else { return nominal.clone() };
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
        fit(&chosen.model, &chosen.states, self.data, ALL).unwrap_or_else(|| chosen.clone())
    }
}

/// Id of the last term.
pub fn last_id(fitted: &Fitted) -> &'static str {
    fitted.model.terms.last().map_or("", |t| t.effect.id)
}
