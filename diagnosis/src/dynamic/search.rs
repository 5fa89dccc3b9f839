//! Which effects: forward by screening and full refits, each chosen on rows that did not fit it, then
//! backward, and with exchanges. The way in which the drive runs between its samples is chosen anew with
//! every effect, since a missing effect can hide it.

mod augmented;
pub mod contenders;
mod exchange;
mod grow;
mod named;
mod rare_saturation;

use numerics::parallel;

use super::data::{ALL, CHOOSE, CHOOSE_ROWS, Data, FIT_ROWS, FOLDS, Folds, over};
use super::estimate::{Fitted, Simulated};
use super::model::Model;
use super::noise::autoregression;
use crate::thresholds::dynamic::search::{
    GAIN_PER_PARAMETER, LEAST_GAIN, LEAST_PART, MOST_EXCHANGES, RARE_GAIN,
};
pub use augmented::Augmented;

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
pub struct Search<'a, M: Augmented = Model> {
    /// The rows.
    pub data: &'a Data<'a>,
    /// The effects that may be named.
    pub catalogue: Vec<M::Effect>,
    /// Number of terms, the first ones, that the nominal plant has and that are not in question.
    pub given: usize,
}

impl<M: Augmented> Search<'_, M> {
    /// The whitening filter of a model's residual.
    pub fn whitening(&self, fitted: &Fitted<M>) -> Vec<f64> {
        let residual = fitted.residual(self.data);
        residual.map_or_else(Vec::new, |r| autoregression(&r, &self.data.runs).coefficients)
    }

    /// A model fitted to the rows that fit.
    pub fn fit(&self, model: &M, states: &[M::Start]) -> Option<Fitted<M>> {
        model.fitted(states, self.data, FIT_ROWS)
    }

    /// Those of some contenders that are worth their parameters.
    pub fn worthy(&self, present: &Fitted<M>, mut contenders: Vec<Fitted<M>>) -> Vec<Fitted<M>> {
        contenders.retain(|f| M::worth(self, present, f));
        contenders
    }

    /// The best contender, or a simpler one that does as well.
    pub fn simplest<'b>(&self, contenders: &'b [Fitted<M>]) -> Option<&'b Fitted<M>> {
        let best = contenders.first()?;
        let free = |f: &Fitted<M>| f.model.packed().len();
        let near = |f: &&Fitted<M>| {
            let more = free(best).saturating_sub(free(f)) as f64;
            free(f) <= free(best) && gain(f, best, CHOOSE_ROWS) < 2.0 + 4.0 * more
        };
        let rank = |id: &str| self.catalogue.iter().position(|e| M::id(e) == id).unwrap_or(usize::MAX);
        contenders.iter().filter(near).min_by_key(|f| (free(f), rank(last_id(f))))
    }

    /// The model without the terms that a later one has made idle.
    pub fn pruned(&self, mut present: Fitted<M>) -> Fitted<M> {
        while present.model.terms().len() > 1 + self.given {
            let last = present.model.terms().len() - 1;
            let shorter = parallel::indices(self.given..last, |k| {
                self.fit(&present.model.without(k)?, &present.states).filter(|f| !M::worth(self, f, &present))
            });
            match shorter.into_iter().flatten().min_by(|a, b| a.costs[CHOOSE].total_cmp(&b.costs[CHOOSE])) {
                Some(f) => present = f,
                None => break,
            }
        }
        present
    }
}

/// Id of the last term.
pub fn last_id<M: Augmented>(fitted: &Fitted<M>) -> &str {
    fitted.model.terms().last().map_or("", |term| M::id(M::effect(term)))
}
